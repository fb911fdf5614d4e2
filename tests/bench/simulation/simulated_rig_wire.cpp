// The simulated ends of a rig: what is served and where, and what each instrument says of itself.
#include "bench/simulation/simulated_rig.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "bench/rig/rig.h"
#include "tests/bench/run/control/apart.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;

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
