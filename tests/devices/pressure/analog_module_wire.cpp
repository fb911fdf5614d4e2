#include "devices/pressure/analog_module.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct ModuleRig {
  explicit ModuleRig(SimulatedModuleFaults faults = {}, Nanoseconds timeout = kPatient)
      : server(std::make_unique<SimulatedModule>(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults)),
        module(module_profile("beckhoff-ek9000"), {"127.0.0.1", server->port(), 1, timeout}, 1000ms, clock,
               Origin::kSimulated),
        regulator(module, module, options(), clock) {}

  static RegulatorOptions options() {
    RegulatorOptions options;
    options.serial = "R1";
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    options.origin = Origin::kSimulated;
    return options;
  }
  static TransducerOptions transducer() {
    TransducerOptions options;
    options.model = "transducer";
    options.span.high = Psi(100.0);
    return options;
  }
  [[nodiscard]] ModbusLink foreign(Nanoseconds timeout = kPatient) {
    return ModbusLink({"127.0.0.1", server->port(), 1, timeout}, "foreign master", clock);
  }

  TurnedClock clock;
  TestChamber chamber{clock};
  std::unique_ptr<SimulatedModule> server;
  AnalogModule module;
  Regulator regulator;
};

void write_one(ModbusLink& link, int address, std::uint16_t value) {
  link.write_registers(address, std::span(&value, 1));
}

std::uint16_t register_at(ModbusLink& link, int address) {
  std::uint16_t value = 0;
  link.read_holding_registers(address, std::span(&value, 1));
  return value;
}

}  // namespace

TEST_CASE("regulator: a command drives the output, feedback and reference come back") {
  ModuleRig rig;
  rig.regulator.arm();
  const auto exchanges = rig.module.exchanges();
  const auto counts = rig.regulator.command(Psi(60.0));
  CHECK(rig.module.exchanges() - exchanges == 2);
  CHECK(counts == std::lround(60.0 / (9.0 * kPsiPerBar) * 0x7FFF));
  CHECK(rig.module.output(0) == counts);
  CHECK(rig.chamber.output().value() == Approx(4.5965).margin(0.0005));
  rig.clock.wait_until(300ms);
  rig.chamber.reference_volts = Volts(5.95);
  const auto feedback = rig.regulator.feedback();
  CHECK(feedback.pressure.value() == Approx(60.0).margin(0.002));
  CHECK(feedback.counts == counts);
  CHECK(feedback.time == 300ms);
  ModuleTransducer transducer(rig.module, ModuleRig::transducer());
  const auto before = rig.module.exchanges();
  const auto reference = transducer.read();
  CHECK(reference.pressure.value() == Approx(59.5).margin(0.002));
  CHECK(reference.voltage.value() == Approx(5.95).margin(0.0002));
  CHECK(rig.module.exchanges() == before);  // the same image serves both
  rig.clock.wait_until(400ms);
  rig.chamber.reference_volts = Volts(6.0);
  CHECK(transducer.read().pressure.value() == Approx(60.0).margin(0.002));
}

TEST_CASE("regulator: fed in time the watchdog holds, unfed it zeroes the output in process time") {
  ModuleRig rig;
  rig.regulator.arm();
  rig.regulator.command(Psi(40.0));
  for (int i = 1; i <= 50; ++i) {
    rig.clock.wait_until(i * 400ms);
    rig.regulator.keep_alive();
  }
  CHECK(rig.regulator.feedback().pressure.value() == Approx(40.0).margin(0.003));
  rig.clock.wait_until(20s + 999ms);
  CHECK(rig.regulator.feedback().pressure.value() == Approx(40.0).margin(0.003));  // reading does not feed
  rig.clock.wait_until(21s);
  CHECK(rig.regulator.feedback().pressure == Psi(0.0));
  check_fault([&] { rig.regulator.keep_alive(); }, "TB-MODULE-WATCHDOG", {}, "1000 ms");
  CHECK(rig.chamber.output() == Volts(0.0));
  CHECK(rig.regulator.vent());  // refused as a write, but all outputs read 0
  rig.regulator.arm();
  rig.regulator.command(Psi(10.0));
  CHECK(rig.regulator.feedback().pressure.value() == Approx(10.0).margin(0.003));
}

TEST_CASE("regulator: a watchdog that still ran and fell back before the first command is set up again") {
  const bool reads_first = GENERATE(true, false);
  ModuleRig rig;
  rig.regulator.arm();
  rig.regulator.command(Psi(40.0));
  CHECK(rig.regulator.vent());
  rig.regulator.arm();
  rig.clock.wait_until(5s);  // other instruments take their time to open
  if (reads_first) CHECK(fault_id_of([&] { rig.regulator.keep_alive(); }) == "none");
  CHECK(fault_id_of([&] { rig.regulator.command(Psi(10.0)); }) == "none");
  CHECK(rig.regulator.feedback().pressure.value() == Approx(10.0).margin(0.003));
  rig.clock.wait_until(6s);  // it watches again
  CHECK(rig.regulator.feedback().pressure == Psi(0.0));
  CHECK(fault_id_of([&] { rig.regulator.keep_alive(); }) == "TB-MODULE-WATCHDOG");
}

TEST_CASE("analog module: with the lock on only the first writer writes") {
  ModuleRig rig;
  auto first = rig.foreign();
  auto second = rig.foreign();
  write_one(first, 0x0800, 500);
  CHECK(fault_id_of([&] { write_one(second, 0x0800, 600); }) == "TB-MODBUS-EXCEPTION");
  CHECK(register_at(second, 0x0800) == 500);
  CHECK(fault_id_of([&] { rig.module.write(0, 700); }) == "TB-MODBUS-EXCEPTION");
  CHECK_FALSE(rig.module.zero_outputs());  // and reports it, rather than claim a vented chamber
  first.close();
  write_one(second, 0x0800, 600);
  CHECK(register_at(second, 0x0800) == 600);
}
