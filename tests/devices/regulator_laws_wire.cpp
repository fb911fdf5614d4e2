// The laws that every actuator obeys (devices/actuator.h), for the regulator behind its module. The stage's stand in
// zaber_laws_wire.cpp.
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

constexpr Nanoseconds kPatient = 20s;
constexpr Nanoseconds kShort = 100ms;

struct Bench {
  explicit Bench(const std::string& profile, SimulatedModuleFaults faults = {}, Nanoseconds timeout = kPatient)
      : known(module_profile(profile)),
        server(std::make_unique<SimulatedModule>(known, 0, chamber, clock, faults)),
        module(known, {"127.0.0.1", server->port(), 1, timeout}, watchdog(), clock, Origin::kSimulated),
        regulator(module, module, options(), clock) {}
  [[nodiscard]] Nanoseconds watchdog() const { return known.fail_safe.watchdog_address >= 0 ? 1000ms : 0ms; }
  static RegulatorOptions options() {
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = psi_from_bar(9.0);
    return options;
  }
  // The server goes and comes back on the same port; the output terminal keeps what it had.
  void power_cycle_wire() {
    const int port = server->port();
    server.reset();
    server = std::make_unique<SimulatedModule>(known, port, chamber, clock);
  }

  ModuleProfile known;
  TurnedClock clock;
  TestChamber chamber{clock};
  std::unique_ptr<SimulatedModule> server;
  AnalogModule module;
  Regulator regulator;
};

const char* const kProfiles[] = {"beckhoff-ek9000", "advantech-adam-6024", "generic"};

}  // namespace

TEST_CASE("law: silent until armed, reading apart") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    Bench bench(profile);
    CHECK(fault_id_of([&] { bench.regulator.command(Psi(20.0)); }) == "TB-CHAMBER-NOT-ARMED");
    CHECK(bench.module.exchanges() == 0);
    bench.clock.wait_until(10s);
    bench.regulator.keep_alive();  // only reads
    (void)bench.regulator.feedback();
    CHECK(bench.chamber.drives == 0);
    bench.regulator.arm();
    CHECK(bench.chamber.drives == 0);
    bench.regulator.command(Psi(20.0));
    CHECK(bench.chamber.drives > 0);
    bench.regulator.disarm();
    CHECK(fault_id_of([&] { bench.regulator.command(Psi(10.0)); }) == "TB-CHAMBER-NOT-ARMED");
  }
}

TEST_CASE("law: what is out of range is refused before anything is sent") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    Bench bench(profile);
    bench.regulator.arm();
    const auto exchanges = bench.module.exchanges();
    for (const double psi : {60.0001, -0.0001, std::nan(""), HUGE_VAL}) {
      CHECK(fault_id_of([&] { bench.regulator.command(Psi(psi)); }) == "TB-CHAMBER-LIMIT");
    }
    CHECK(bench.module.exchanges() == exchanges);
    CHECK(bench.regulator.armed());
  }
}

TEST_CASE("law: it vents from any state, armed or not, twice") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    Bench bench(profile);
    CHECK(bench.regulator.vent());  // never armed
    bench.regulator.arm();
    CHECK(bench.regulator.vent());  // armed, nothing commanded
    bench.regulator.command(Psi(50.0));
    REQUIRE(bench.chamber.output() > Volts(3.8));
    CHECK(bench.regulator.vent());
    CHECK(bench.chamber.output() == Volts(0.0));
    CHECK(bench.regulator.vent());
    bench.regulator.command(Psi(50.0));
    bench.regulator.disarm();
    CHECK(bench.regulator.vent());
    CHECK(bench.chamber.output() == Volts(0.0));
    bench.regulator.arm();
    bench.regulator.command(Psi(50.0));
    bench.power_cycle_wire();
    CHECK(bench.regulator.vent());
    CHECK(bench.chamber.output() == Volts(0.0));
  }
}

TEST_CASE("law: a quiet wire becomes a fault within its deadline, and disarms") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    Bench bench(profile, {.silent_after_requests = 40}, kShort);
    bench.regulator.arm();
    std::string id = "none";
    for (int i = 0; i < 60 && id == "none"; ++i) id = fault_id_of([&] { bench.regulator.command(Psi(5.0)); });
    CHECK(id == "TB-MODBUS-TIMEOUT");
    CHECK(bench.clock.now() == kShort);  // one reply lost, no more
    CHECK_FALSE(bench.regulator.armed());
    CHECK(fault_id_of([&] { bench.regulator.command(Psi(5.0)); }) == "TB-CHAMBER-NOT-ARMED");
  }
}

TEST_CASE("law: after the wire comes back nothing remembered is sent, and the first feeding is 0 V") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    Bench bench(profile);
    bench.regulator.arm();
    bench.regulator.command(Psi(50.0));
    bench.power_cycle_wire();
    bench.clock.wait_until(500ms);
    CHECK(fault_id_of([&] { bench.regulator.keep_alive(); }) != "none");
    CHECK_FALSE(bench.regulator.armed());
    const int drives = bench.chamber.drives;
    bench.regulator.keep_alive();
    (void)bench.regulator.feedback();
    CHECK(bench.chamber.drives == drives);
    bench.regulator.arm();
    CHECK(bench.chamber.drives == drives);
    bench.regulator.keep_alive();
    CHECK(bench.chamber.output() == Volts(0.0));
  }
}

TEST_CASE("module: a channel in safe mode is cleared at arming, and that is verified") {
  TurnedClock clock;
  TestChamber chamber(clock);
  const ModuleProfile outputs = module_profile("moxa-iologik-e1241");
  const ModuleProfile inputs = module_profile("moxa-iologik-e1240");
  SimulatedUnit out{1, outputs, {}, true};
  SimulatedModule server({out, {2, inputs, {}}}, SimulatedModule::Wire::kTcp, 0, chamber, clock);
  AnalogModule output(outputs, {"127.0.0.1", server.port(), 1, kPatient}, 0s, clock, Origin::kSimulated);
  AnalogModule input(inputs, output, 2, clock, Origin::kSimulated);
  Regulator regulator(output, input, Bench::options(), clock);
  CHECK(fault_id_of([&] { output.write(0, 100); }) == "TB-MODULE-READBACK");  // safe mode ignores it
  regulator.arm();
  regulator.command(Psi(30.0));
  CHECK(regulator.feedback().pressure.value() == Approx(30.0).margin(0.05));
}

TEST_CASE("module: a status word that names a channel out of range is a fault") {
  TurnedClock clock;
  TestChamber chamber(clock);
  ModuleProfile adam = module_profile("advantech-adam-6024");
  SimulatedModule server(adam, 0, chamber, clock);
  adam.inputs.status_offset = 10;  // where the outputs stand: whatever is written there is taken for a status
  AnalogModule module(adam, {"127.0.0.1", server.port(), 1, kPatient}, 0s, clock, Origin::kSimulated);
  module.refresh();
  const auto fault = fault_of([&] { module.write(1, 2); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-MODULE-INPUT");
  CHECK_THAT(fault->what(), Catch::Contains("input 1") && Catch::Contains("below its range"));
}
