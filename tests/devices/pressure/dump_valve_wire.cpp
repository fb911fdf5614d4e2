#include <catch2/catch.hpp>

#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
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
