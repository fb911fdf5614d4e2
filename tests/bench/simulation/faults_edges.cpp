// The schedule of faults at its edges: from its very moment to its end, at just the load, the last of several.
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/simulation/faults.h"
#include "bench/simulation/specimen.h"

using namespace tactbench::bench;
using namespace std::chrono_literals;
using tactbench::devices::InjectedFault;
using tactbench::devices::Nanoseconds;

namespace {

PlannedFault fault_of_kind(FaultKind kind) {
  PlannedFault fault;
  fault.kind = kind;
  return fault;
}

}  // namespace

TEST_CASE("faults: in force from its moment on, and no longer than it lasts, to the nanosecond") {
  PlannedFault leak = fault_of_kind(FaultKind::kLeak);
  leak.at_s = 2.0;
  leak.lasts_s = 0.5;
  const Faults faults({leak});
  CHECK(faults.any());
  CHECK_FALSE(faults.active(FaultKind::kLeak, 2s - 1ns));
  CHECK(faults.active(FaultKind::kLeak, 2s) == 5.0);
  CHECK(faults.active(FaultKind::kLeak, 2500ms - 1ns));
  CHECK_FALSE(faults.active(FaultKind::kLeak, 2500ms));
  CHECK_FALSE(faults.active(FaultKind::kValveStuck, 2s));
  const Faults at_once({fault_of_kind(FaultKind::kValveStuck)});
  CHECK(at_once.active(FaultKind::kValveStuck, 0ns) == 0.0);
}

TEST_CASE("faults: each kind's usual value, an own value, and an overshoot is one time") {
  CHECK(usual_value(FaultKind::kLeak) == 5.0);
  CHECK(usual_value(FaultKind::kOvershoot) == 2.0);
  CHECK(usual_value(FaultKind::kSupplyLost) == 0.2);
  CHECK(usual_value(FaultKind::kFeedbackOffset) == 10.0);
  CHECK(usual_value(FaultKind::kReferenceOffset) == 10.0);
  for (const FaultKind none : {FaultKind::kValveStuck, FaultKind::kRegulatorUnpowered, FaultKind::kStageStalled,
                               FaultKind::kRowStuck, FaultKind::kModuleLate})
    CHECK(usual_value(none) == 0.0);
  PlannedFault own = fault_of_kind(FaultKind::kOvershoot);
  own.value = 3.5;
  Faults once({own});
  CHECK(once.take(FaultKind::kOvershoot, 1s) == 3.5);
  CHECK_FALSE(once.take(FaultKind::kOvershoot, 1s));
  own.times = 2;
  Faults twice({own});
  CHECK(twice.take(FaultKind::kOvershoot, 1s));
  CHECK(twice.active(FaultKind::kOvershoot, 1s));  // looking does not count
  CHECK(twice.take(FaultKind::kOvershoot, 1s));
  CHECK_FALSE(twice.active(FaultKind::kOvershoot, 1s));
}

TEST_CASE("faults: started by just the load, by either of two, once, and waiting no longer afterwards") {
  PlannedFault by_psi = fault_of_kind(FaultKind::kLeak), by_force = fault_of_kind(FaultKind::kForceStale);
  by_psi.at_psi = 20.0;
  by_psi.lasts_s = 1.0;
  by_force.at_n = 5.0;
  by_force.at_psi = 40.0;
  Faults faults({by_psi, by_force});
  faults.load(19.999, 4.999, 1s);
  CHECK_FALSE(faults.active(FaultKind::kLeak, 1s));
  CHECK_FALSE(faults.active(FaultKind::kForceStale, 1s));
  faults.load(20.0, 0.0, 2s);
  CHECK(faults.active(FaultKind::kLeak, 2s));
  CHECK_FALSE(faults.active(FaultKind::kLeak, 3s));
  faults.load(30.0, 5.0, 4s);
  CHECK_FALSE(faults.active(FaultKind::kLeak, 4s));  // it was once
  CHECK_FALSE(faults.active(FaultKind::kForceStale, 4s - 1ns));
  CHECK(faults.active(FaultKind::kForceStale, 4s));
  Faults other({by_force});
  other.load(40.0, 0.0, 1s);
  CHECK(other.active(FaultKind::kForceStale, 1s));
  // A time and a load: whichever is first.
  by_psi.at_s = 10.0;
  Faults early({by_psi}), late({by_psi});
  early.load(25.0, 0.0, 3s);
  CHECK(early.active(FaultKind::kLeak, 3s));
  CHECK_FALSE(early.active(FaultKind::kLeak, 10s));
  CHECK_FALSE(late.active(FaultKind::kLeak, 9s));
  CHECK(late.active(FaultKind::kLeak, 10s));
  late.load(25.0, 0.0, 10s);
  CHECK_FALSE(late.active(FaultKind::kLeak, 11s));  // its second began at its own time
}

TEST_CASE("faults: cleared from now on, what is planned for later stays, and the last window is the newest begun") {
  PlannedFault first = fault_of_kind(FaultKind::kStageStalled), second = first;
  first.at_s = 1.0;
  first.value = 3.0;
  second.at_s = 5.0;
  second.lasts_s = 2.0;
  second.value = 1.0;
  Faults faults({second, first});
  CHECK_FALSE(faults.last(FaultKind::kStageStalled, 1s - 1ns).from);
  CHECK(faults.last(FaultKind::kStageStalled, 1s).from == Nanoseconds(1s));
  CHECK(faults.last(FaultKind::kStageStalled, 1s).value == 3.0);
  CHECK_FALSE(faults.last(FaultKind::kStageStalled, 1s).until);
  CHECK(faults.last(FaultKind::kStageStalled, 5s).value == 1.0);
  CHECK(faults.last(FaultKind::kStageStalled, 5s).until == Nanoseconds(7s));
  faults.clear(FaultKind::kStageStalled, 3s);
  faults.clear(FaultKind::kLeak, 3s);
  CHECK(faults.active(FaultKind::kStageStalled, 3s - 1ns));
  CHECK_FALSE(faults.active(FaultKind::kStageStalled, 3s));
  CHECK(faults.last(FaultKind::kStageStalled, 3s).until == Nanoseconds(3s));
  CHECK(faults.active(FaultKind::kStageStalled, 5s) == 1.0);
  faults.clear(FaultKind::kStageStalled, 7s);  // over by itself: its end stays
  CHECK(faults.last(FaultKind::kStageStalled, 8s).until == Nanoseconds(7s));
  faults.inject(fault_of_kind(FaultKind::kStageStalled), 9s);
  faults.clear(FaultKind::kStageStalled, 9s);
  CHECK_FALSE(faults.active(FaultKind::kStageStalled, 9s));
  Faults none({});
  CHECK_FALSE(none.any());
  CHECK_FALSE(none.last(FaultKind::kStageStalled, 9s).from);
  CHECK(none.injected(Instrument::kStage, 1s) == InjectedFault::kNone);
}

TEST_CASE("faults: each kind maps to a defect of one instrument") {
  const auto met = [](FaultKind kind, Instrument instrument) {
    Faults faults({fault_of_kind(kind)});
    return faults.injected(instrument, 1s);
  };
  using I = Instrument;
  using T = InjectedFault;
  using K = FaultKind;
  const std::vector<std::tuple<K, I, T>> table = {{K::kModuleSilent, I::kModule, T::kSilent},
                                                  {K::kModuleLate, I::kModule, T::kLate},
                                                  {K::kModuleCorrupt, I::kModule, T::kCorrupt},
                                                  {K::kModuleStale, I::kModule, T::kStale},
                                                  {K::kModuleException, I::kModule, T::kRefused},
                                                  {K::kModuleUnplugged, I::kModule, T::kUnplugged},
                                                  {K::kStageSilent, I::kStage, T::kSilent},
                                                  {K::kStageLate, I::kStage, T::kLate},
                                                  {K::kStageCorrupt, I::kStage, T::kCorrupt},
                                                  {K::kStageTorn, I::kStage, T::kTorn},
                                                  {K::kStageUnplugged, I::kStage, T::kUnplugged},
                                                  {K::kForceSaturated, I::kForce, T::kSaturated},
                                                  {K::kForceStale, I::kForce, T::kStale},
                                                  {K::kForceSilent, I::kForce, T::kSilent},
                                                  {K::kScannerSilent, I::kScanner, T::kSilent},
                                                  {K::kScannerStale, I::kScanner, T::kStale},
                                                  {K::kScannerCorrupt, I::kScanner, T::kCorrupt},
                                                  {K::kScannerTorn, I::kScanner, T::kTorn},
                                                  {K::kScannerUnplugged, I::kScanner, T::kUnplugged}};
  for (const auto& [kind, instrument, trouble] : table) {
    INFO(fault_words()[static_cast<std::size_t>(kind)]);
    for (const I asked : {I::kModule, I::kStage, I::kForce, I::kScanner})
      CHECK(met(kind, asked) == (asked == instrument ? trouble : T::kNone));
  }
  for (const K other : {K::kLeak, K::kRowStuck, K::kStageStalled}) {
    for (const I asked : {I::kModule, I::kStage, I::kForce, I::kScanner}) CHECK(met(other, asked) == T::kNone);
  }
}

TEST_CASE("specimen state: of another array, another program or with a value that is none, each is refused") {
  SpecimenOptions options;
  options.rows = 2;
  options.columns = 3;
  Specimen specimen(options);
  specimen.advance(10.0, 1.0);
  const auto state = nlohmann::json::parse(specimen.state());
  const auto accepts = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json changed = state;
    change(changed);
    try {
      specimen.set_state(changed.dump());
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  };
  CHECK(accepts([](auto&) {}));
  CHECK_FALSE(accepts([](auto& json) { json["format"] = "other"; }));
  CHECK_FALSE(accepts([](auto& json) { json["version"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["sensor_seed"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["rows"] = 3; }));
  CHECK_FALSE(accepts([](auto& json) { json["columns"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["virgin"] = nullptr; }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"].erase(5); }));
  CHECK_FALSE(accepts([](auto& json) { json["creep"].push_back(json["creep"][0]); }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"][2].push_back(1.0); }));
  CHECK_FALSE(accepts([](auto& json) { json["creep"][2].erase(0); }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"][2][5] = -1e-12; }));
  CHECK(accepts([](auto& json) { json["plays"][2][5] = 0.0; }));
  CHECK(accepts([](auto& json) { json["travel_psi"] = 77.0; }));
  CHECK(nlohmann::json::parse(specimen.state())["travel_psi"] == 77.0);
}
