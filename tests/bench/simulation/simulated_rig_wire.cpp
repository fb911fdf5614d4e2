// The simulated ends of a rig: what is served and where, and what each instrument says of itself.

#include "bench/simulation/simulated_rig.h"

#include <catch2/catch.hpp>

#include <chrono>
#include <filesystem>
#include <set>

#include "bench/config/config.h"
#include "bench/rig/rig.h"
#include "bench/safety/ramp.h"
#include "bench/simulation/plant.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/bench/run/control/apart.h"
#include "tests/devices/fault_of.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace std::chrono_literals;
using namespace tactbench::bench;
using namespace tactbench::tests;
using devices::Axis;
using devices::fault_id_of;
using devices::Millimetres;

namespace {

struct ServedEnds {
  std::size_t ends = 0, passing = 0;  // passing: at an address that is another the next time
};

ServedEnds served_by(const std::vector<sequences::Override>& changes, bool free_running) {
  bench::BenchConfig config = small_request(changes).bench;
  devices::ManualClock turned;
  devices::SteadyClock steady;
  bench::SimulatedRig rig(config, free_running ? static_cast<devices::Clock&>(steady) : turned, free_running);
  ServedEnds served;
  std::set<std::string> places;
  for (const auto& end : rig.served()) {
    ++served.ends;
    served.passing += rig.ephemeral_addresses().lasting(end.where) != end.where ? 1 : 0;
    CHECK(places.insert(end.where).second);
    CHECK_FALSE(end.what.empty());
  }
  return served;
}

}  // namespace

TEST_CASE("simulated rig: serves each instrument of the bench at its own address, for other processes all kinds") {
  // Module, scanner, stage, force sensor and its page.
  const ServedEnds shipped = served_by({}, false);
  CHECK((shipped.ends == 5 && shipped.passing >= 4));
  CHECK(served_by({{"scanner.kind", "frame-source"}, {"force.kind", "digital"}}, false).ends == 4);
  // A second line of modules, a pressure controller, the other scanner and the other force sensor beside them.
  CHECK(served_by({}, true).ends == 9);
}

TEST_CASE("simulated rig: a killed process leaves no folder for long") {
  const TemporaryFolder folder;
  const Variable temporary("TMPDIR", folder.path());
  const auto folders = [&] {
    return std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator());
  };
  {
    const Apart killed([](const Stay& stay) {
      const bench::Rig rig(small_request().bench);
      stay();
    });
    REQUIRE(killed.ready());
    const bench::Rig beside(small_request().bench);  // of a process that lives
    CHECK(folders() == 2);
  }
  CHECK(folders() == 1);
  { const bench::Rig next(small_request().bench); }
  CHECK(folders() == 0);
}

TEST_CASE("simulated rig: calibration and gauges of the digital force sensor") {
  bench::Rig rig(small_request({{"force.kind", "digital"},
                                {"simulation.contact.surface_z_mm", "20"},
                                {"simulation.contact.stiffness_n_per_mm", "10"},
                                {"simulation.contact.stiffening_n_per_mm2", "0"},
                                {"simulation.contact.friction_share", "0"},
                                {"simulation.contact.relaxation_share", "0"}})
                     .bench);
  devices::ForceSensor& force = rig.open_force();
  CHECK(force.calibration_serial() == "SIMFT2");
  CHECK(force.identity().serial == "SIMFT2");
  CHECK(force.range() == std::array<double, 6>{25.0, 25.0, 35.0, 250.0, 250.0, 250.0});
  (void)force.bias(20);
  devices::Stage& stage = *rig.stage_gate();
  stage.arm();
  stage.home(devices::Axis::kZ);
  (void)force.read(1);
  stage.start_move_to(devices::Axis::kZ, devices::Millimetres(22.5), std::nullopt);
  (void)stage.wait(devices::Axis::kZ);
  const devices::ForceReading reading = force.read(1);
  CHECK(reading.wrench.force_n[2] == Approx(-25.0).margin(0.05));
  CHECK(reading.raw[2] < -1000.0);  // the gauges' counts
}

TEST_CASE("simulated rig: its socket folder is removed with it") {
  std::string folder;
  {
    bench::BenchConfig config = small_request().bench;
    devices::ManualClock clock;
    const bench::SimulatedRig rig(config, clock, false);
    folder = std::filesystem::path(config.scanner.socket).parent_path();
    CHECK(std::filesystem::is_directory(folder));
    CHECK((std::filesystem::status(folder).permissions() & std::filesystem::perms::all) ==
          std::filesystem::perms::owner_all);
  }
  CHECK_FALSE(std::filesystem::exists(folder));
}

// Faults injected into a rig while it runs, as the drivers see them on the wires, and that they can be cleared.

namespace {

BenchConfig quick(std::vector<sequences::Override> overrides = {}) {
  overrides.push_back({"module.response_timeout_ms", "400"});
  overrides.push_back({"scanner.frame_timeout_ms", "400"});
  return small_request(overrides).bench;
}

// A register of the module, straight through its link.
struct ModuleWire {
  explicit ModuleWire(Rig& rig) : link(rig.config().module.endpoint, "module", rig.clock()) {}
  std::string read() {
    return fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); });
  }
  devices::ModbusLink link;
  std::uint16_t value = 0;
};

void hold(Rig& rig, double psi) {
  (void)ramp_to(rig, devices::Psi(psi));
  for (int i = 0; i < 10; ++i) {
    rig.clock().wait_until(rig.clock().now() + 300ms);
    rig.source().keep_alive();
  }
}

}  // namespace

TEST_CASE("module wire faults: each kind gives its own error once, and the next answer is right") {
  const auto [kind, id] = GENERATE(table<FaultKind, std::string>({
      {FaultKind::kModuleSilent, "TB-MODBUS-TIMEOUT"},
      {FaultKind::kModuleLate, "TB-MODBUS-TIMEOUT"},
      {FaultKind::kModuleCorrupt, "TB-MODBUS-PROTOCOL"},
      {FaultKind::kModuleException, "TB-MODBUS-EXCEPTION"},
      {FaultKind::kModuleUnplugged, "TB-MODBUS-CONNECT"},
  }));
  Rig rig(quick());
  ModuleWire wire(rig);
  REQUIRE(wire.read() == "none");
  rig.plant()->inject(kind, std::nullopt, 1);
  CHECK(wire.read() == id);
  CHECK(wire.read() == "none");
  rig.plant()->inject(kind);
  CHECK(wire.read() == id);
  if (kind != FaultKind::kModuleLate) CHECK(wire.read() == id);
  rig.plant()->clear(kind);
  CHECK(wire.read() == "none");
}

TEST_CASE("fault module_stale: commands are accepted while every reading stays constant") {
  Rig rig(quick());
  rig.open();
  hold(rig, 20.0);
  const auto read_later = [&] {
    rig.clock().wait_until(rig.clock().now() + 3s);
    return rig.reference().read().pressure.value();
  };
  REQUIRE(rig.reference().read().pressure.value() == Approx(20.0).margin(1.0));
  rig.plant()->inject(FaultKind::kModuleStale);
  rig.plant()->drive(devices::Volts(3.0), devices::Nanoseconds::max(), devices::Volts(0.0));
  const double stale = read_later();
  CHECK(stale == Approx(20.0).margin(1.0));
  CHECK(read_later() == stale);  // not even its noise
  CHECK(rig.plant()->true_pressure().value() > 30.0);
  rig.plant()->clear(FaultKind::kModuleStale);
  CHECK(read_later() > 30.0);
}

TEST_CASE("scanner wire faults: silent, corrupt, torn and unplugged each give an error, and then recover") {
  const std::string kind_of_scanner = GENERATE("hid", "frame-source");
  const FaultKind kind = GENERATE(FaultKind::kScannerSilent, FaultKind::kScannerCorrupt, FaultKind::kScannerTorn,
                                  FaultKind::kScannerUnplugged);
  Rig rig(quick({{"scanner.kind", kind_of_scanner}}));
  rig.open();
  REQUIRE(fault_id_of([&] { (void)rig.array().read(1); }) == "none");
  rig.plant()->inject(kind);
  const std::string id = fault_id_of([&] { (void)rig.array().read(1); });
  CAPTURE(id);
  CHECK(id.starts_with("TB-SCANNER-"));
  rig.plant()->clear(kind);
  rig.close_array();
  rig.open_array();
  CHECK(fault_id_of([&] { (void)rig.array().read(1); }) == "none");
}

TEST_CASE("fault scanner_stale: the counts do not change with the pressure") {
  Rig rig(quick());
  rig.open();
  hold(rig, 10.0);
  const auto before = rig.array().read(1).counts;
  rig.plant()->inject(FaultKind::kScannerStale);
  hold(rig, 40.0);
  CHECK(rig.array().read(1).counts == before);
  rig.plant()->clear(FaultKind::kScannerStale);
  CHECK(rig.array().read(1).counts != before);
}

TEST_CASE("force sensor wire faults: silent, saturated, and stale on the network sensor, and then recover") {
  const std::string kind_of_sensor = GENERATE("net", "digital");
  Rig rig(quick({{"force.kind", kind_of_sensor}}));
  devices::ForceSensor& force = rig.open_force();
  for (const auto& [kind, id] :
       {std::pair{FaultKind::kForceSaturated, "TB-FORCE-SATURATED"},
        std::pair{FaultKind::kForceStale, "TB-FORCE-STALL"}, std::pair{FaultKind::kForceSilent, "TB-FORCE-TIMEOUT"}}) {
    const bool digital = kind_of_sensor == "digital";
    if (digital && kind == FaultKind::kForceStale) continue;
    CHECK(fault_id_of([&] { (void)force.read(10); }) == "none");
    rig.plant()->inject(kind);
    const std::string met = fault_id_of([&] { (void)force.read(10); });
    CAPTURE(met);
    CHECK((digital ? met.starts_with("TB-FORCE-") : met == id));
    rig.plant()->clear(kind);
  }
  CHECK(fault_id_of([&] { (void)force.read(10); }) == "none");
}

TEST_CASE("fault stage_stalled: at the planned force z stops but reports arrival") {
  Rig rig(quick({{"simulation.faults", "[{kind = \"stage_stalled\", at_n = 5, value = 3}]"}}));
  devices::Stage& stage = *rig.stage();
  stage.arm();
  stage.home(Axis::kZ);
  stage.start_move_to(Axis::kZ, Millimetres(31.0), std::nullopt);
  CHECK(stage.wait(Axis::kZ).value() == Approx(31.0).margin(0.001));
  const double force = rig.plant()->true_force().value();
  CHECK(force > 4.5);
  CHECK(force < 10.0);  // 31 mm would be 31 N
  stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
  stage.wait(Axis::kZ);
  CHECK(rig.plant()->true_force().value() > 4.0);  // it does not retract either
  rig.plant()->clear(FaultKind::kStageStalled);
  stage.home(Axis::kZ);
  CHECK(rig.plant()->true_force().value() == 0.0);
}

TEST_CASE("stage wire faults: lost and corrupted replies and an unplugged line give an error") {
  const FaultKind kind =
      GENERATE(FaultKind::kStageSilent, FaultKind::kStageCorrupt, FaultKind::kStageTorn, FaultKind::kStageUnplugged);
  Rig rig(quick());
  devices::Stage& stage = *rig.stage();
  stage.arm();
  stage.home(Axis::kZ);
  rig.plant()->inject(kind);
  const std::string id = fault_id_of([&] { (void)stage.state(Axis::kZ); });
  CAPTURE(id);
  CHECK(id != "none");
  if (kind == FaultKind::kStageUnplugged) return;
  rig.plant()->clear(kind);
  stage.arm();
  CHECK(fault_id_of([&] { (void)stage.state(Axis::kZ); }) == "none");
}
