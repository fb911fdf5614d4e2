// Each question and each change brings the plant up to its time first: whoever has looked before changes nothing.
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/simulation/small_plant.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using namespace std::chrono_literals;

namespace {

// From 10 psi on.
std::function<void(PlantOptions&)> with_fault(FaultKind kind) {
  return [kind](PlantOptions& options) {
    PlannedFault fault;
    fault.kind = kind;
    fault.at_psi = 10.0;
    options.faults = {fault};
  };
}

}  // namespace

TEST_CASE("plant's questions: a fault that waits for a load begins although nobody asked for the pressure") {
  SmallPlant module(with_fault(FaultKind::kModuleException)), supply(with_fault(FaultKind::kSupplyLost));
  SmallPlant monitor(with_fault(FaultKind::kRegulatorUnpowered)), reference(with_fault(FaultKind::kReferenceOffset));
  for (SmallPlant* bed : {&module, &supply, &monitor, &reference}) {
    bed->drive(2.0);
    bed->at(3s);
  }
  CHECK(module.plant.injected(Instrument::kModule) == devices::InjectedFault::kRefused);
  CHECK(supply.plant.supply_bar() == 0.0);
  CHECK(monitor.plant.feedback().value() == 0.0);
  CHECK(reference.plant.reference_pressure().value() > 30.0);  // 26 psi, and 10
  SmallPlant below(with_fault(FaultKind::kModuleException));
  below.drive(0.5);
  below.at(3s);
  CHECK(below.plant.injected(Instrument::kModule) == devices::InjectedFault::kNone);
}

TEST_CASE("plant's questions: a fault that has begun meanwhile is cleared, one that has not stays") {
  for (const bool begun : {true, false}) {
    SmallPlant bed(with_fault(FaultKind::kSupplyLost));
    bed.drive(begun ? 2.0 : 0.5);
    bed.at(3s);
    bed.plant.clear(FaultKind::kSupplyLost);
    bed.drive(2.0);
    bed.at(8s);
    CHECK(bed.plant.supply_bar() == (begun ? 8.0 : 0.0));
  }
}

TEST_CASE("plant's questions: a look before a change leaves all as it is") {
  // What happens at 257 ms, between two cells of the grid.
  ScriptedStage stage([](double) { return ScriptedStage::Place{30.0, 30.0, 30.3}; });
  const std::vector<std::pair<std::string, std::function<void(SmallPlant&)>>> changes = {
      {"a stage is set", [&](SmallPlant& bed) { bed.plant.set_stage(&stage); }},
      {"a fault begins", [](SmallPlant& bed) { bed.plant.inject(FaultKind::kLeak, 4.0); }},
      {"a command", [](SmallPlant& bed) { bed.drive(1.0); }},
      {"a command with a limit",
       [](SmallPlant& bed) { bed.plant.drive(devices::Volts(3.0), 391ms, devices::Volts(0.5)); }},
      {"the dump valve opens, and closes",
       [](SmallPlant& bed) {
         bed.plant.dump(true);
         bed.at(304ms);
         bed.plant.dump(false);
       }},
      {"another memory of the film",
       [](SmallPlant& bed) { bed.plant.set_specimen_state(SmallPlant().plant.specimen_state()); }},
  };
  for (const auto& [what, change] : changes) {
    INFO(what);
    SmallPlant looked, unseen;
    for (SmallPlant* bed : {&looked, &unseen}) {
      bed->drive(3.0);
      bed->at(257ms);
      if (bed == &looked) {
        (void)bed->plant.true_pressure();
        (void)bed->plant.true_force();
        (void)bed->plant.true_output();
        (void)bed->plant.specimen_state();
      }
      change(*bed);
      bed->at(777ms);
    }
    CHECK(looked.plant.true_pressure().value() == unseen.plant.true_pressure().value());
    CHECK(looked.plant.true_force().value() == unseen.plant.true_force().value());
    CHECK(looked.plant.true_output() == unseen.plant.true_output());
    CHECK(looked.plant.specimen_state() == unseen.plant.specimen_state());
  }
}

TEST_CASE("plant's questions: each looks at the present, not at what was asked last") {
  const auto bed_at = [](devices::Nanoseconds time) {
    auto bed = std::make_unique<SmallPlant>();
    bed->drive(3.0);
    bed->at(time);
    return bed;
  };
  CHECK(bed_at(1s)->plant.true_pressure().value() > 20.0);
  CHECK(bed_at(1s)->plant.reference_pressure().value() > 20.0);
  CHECK(bed_at(1s)->plant.reference().value() > 2.0);
  CHECK(bed_at(1s)->plant.feedback().value() > 1.5);
  CHECK(bed_at(1s)->plant.true_output()[0] > bed_at(10ms)->plant.true_output()[0] + 0.1);
  CHECK(bed_at(1s)->scan()[0] > bed_at(10ms)->scan()[0] + 1000);
  CHECK(bed_at(1s)->plant.specimen_state() != bed_at(10ms)->plant.specimen_state());
  // A memory that was set is read at once.
  auto bed = bed_at(1s);
  const std::string fresh = SmallPlant().plant.specimen_state();
  bed->plant.set_specimen_state(fresh);
  CHECK(bed->plant.specimen_state() == fresh);
  const std::vector<double> before = bed->plant.true_output();
  bed->at(1100ms);
  CHECK(bed->plant.true_output() != before);
}
