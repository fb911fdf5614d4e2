#include <atomic>
#include <catch2/catch.hpp>

#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/recorded_module.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

class DumpingChamber final : public ChamberPort {
 public:
  void drive(Volts, Nanoseconds, Volts) override {}
  void dump(bool open) override {
    open_ = open;
    ++orders_;
  }
  Volts feedback() override { return Volts(0.0); }
  Volts reference() override { return Volts(0.0); }
  [[nodiscard]] bool open() const { return open_; }
  [[nodiscard]] int orders() const { return orders_; }

 private:
  std::atomic<bool> open_{false};
  std::atomic<int> orders_{0};
};

ModuleProfile with_valve(int coil) {
  ModuleProfile profile = module_profile("beckhoff-ek9000");
  profile.dump_coil = coil;
  return profile;
}

struct DumpValveRig {
  explicit DumpValveRig(int coil = 3, SimulatedModuleFaults faults = {})
      : server(with_valve(coil), 0, chamber, clock, faults),
        module(with_valve(coil), {"127.0.0.1", server.port(), 1, kPatient}, 1000ms, clock, Origin::kSimulated),
        regulator(module, module, options(), clock) {}
  static RegulatorOptions options() {
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    return options;
  }
  TurnedClock clock;
  DumpingChamber chamber;
  SimulatedModule server;
  AnalogModule module;
  Regulator regulator;
};

}  // namespace

TEST_CASE("dump valve: open until armed, open after a vent, closed again by the next pressure") {
  DumpValveRig rig;
  CHECK(rig.chamber.open());  // without power
  rig.regulator.arm();
  CHECK_FALSE(rig.chamber.open());
  (void)rig.regulator.command(Psi(5.0));
  const int orders = rig.chamber.orders();
  CHECK(rig.regulator.vent());
  CHECK(rig.chamber.open());
  (void)rig.regulator.command(Psi(0.0));
  CHECK(rig.chamber.open());
  (void)rig.regulator.command(Psi(5.0));
  CHECK_FALSE(rig.chamber.open());
  (void)rig.regulator.command(Psi(6.0));
  CHECK(rig.chamber.orders() == orders + 2);  // called only when it changes
}

TEST_CASE("dump valve: the module's watchdog opens it") {
  DumpValveRig rig;
  rig.regulator.arm();
  (void)rig.regulator.command(Psi(5.0));
  rig.clock.wait_until(rig.clock.now() + 1500ms);
  (void)rig.module.read_all();
  CHECK(rig.chamber.open());
}

TEST_CASE("dump valve: without one in the profile no output is switched") {
  DumpValveRig rig(-1);
  rig.regulator.arm();
  CHECK(rig.regulator.vent());
  CHECK(rig.chamber.orders() == 0);
}

TEST_CASE("analog module: the dump valve's coil is switched once to close, and twice at most to open") {
  ModuleProfile profile;
  profile.inputs.channels = 0;
  for (const int coil : {0, 9}) {
    profile.dump_coil = coil;
    const std::string note = coil == 0 ? "5 0000" : "5 0009";
    RecordedModule server;
    TurnedClock clock;
    AnalogModule module(profile, server.endpoint(), 0ns, clock, Origin::kSimulated);
    module.close_dump();
    module.close_dump();
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280"});
    CHECK(module.open_dump());
    CHECK(server.notes() == RecordedModule::Notes{note + " <0"});
    server.interfere([](const std::string&) { return 4; });
    CHECK(fault_id_of([&] { module.close_dump(); }) == "TB-MODBUS-EXCEPTION");
    CHECK(server.connections() == 1);
    CHECK_FALSE(module.open_dump());
    CHECK(server.connections() == 2);  // the second attempt is made on a new one
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280", note + " <0", note + " <0"});
    std::atomic<int> left = 1;
    server.interfere([&](const std::string&) { return left-- > 0 ? std::optional(0) : std::nullopt; });
    CHECK(module.open_dump());
    CHECK(server.notes().size() == 2);
    module.close_dump();  // a failed order to close has not made it closed
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280"});
  }
  profile.dump_coil = -1;
  RecordedModule none;
  TurnedClock clock;
  AnalogModule module(profile, none.endpoint(), 0ns, clock, Origin::kSimulated);
  module.close_dump();
  CHECK(module.open_dump());
  CHECK(none.notes().empty());
}
