// The simulated ends of a rig: what is served and where, and what each instrument says of itself.
#include "bench/simulation/simulated_rig.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>

#include "bench/rig/rig.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::vector<std::string> served_by(const std::vector<sequences::Override>& changes, bool free_running) {
  bench::BenchConfig config = small_request(changes).bench;
  devices::TurnedClock turned;
  devices::SteadyClock steady;
  bench::SimulatedRig rig(config, free_running ? static_cast<devices::Clock&>(steady) : turned, free_running);
  std::vector<std::string> lines;
  static const std::regex kDiffers("[^ ]*/tactbench-[A-Za-z0-9]{6}|127.0.0.1:[0-9]+|/dev/pts/[0-9]+|(port|on) [0-9]+");
  for (const auto& served : rig.served()) {
    lines.push_back(served.what + ": " + std::regex_replace(served.where, kDiffers, "..."));
    // What passes has a lasting name.
    if (served.what != "pressure and environment") CHECK(rig.passing_names().lasting(served.where) != served.where);
  }
  return lines;
}

}  // namespace

TEST_CASE("simulated rig: what it serves and where, in its program alone and for others") {
  const std::string module = "pressure and environment: Modbus TCP ..., unit 1: Beckhoff EK9000 + EL4xxx/EL3xxx";
  const std::string reports = "tactile scanner, HID reports over SOCK_SEQPACKET: .../scanner";
  const std::string frames = "tactile scanner, frame-source protocol over TCP: tcp:...";
  const std::string stage = "stage, Zaber binary chain (firmware 5): ...";
  const std::string net = "Nano17, Net F/T (RDT over UDP): ...";
  const std::string page = "Nano17, its calibration page: http://.../netftapi2.xml";
  const std::string digital = "Nano17, Digital F/T (RS-485): ...";
  CHECK(served_by({}, false) == std::vector<std::string>{module, reports, stage, net, page});
  CHECK(served_by({{"scanner.kind", "frame-source"}, {"force.kind", "digital"}}, false) ==
        std::vector<std::string>{module, frames, stage, digital});
  const std::string line =
      "pressure and environment: Modbus RTU ..., unit 1: Waveshare Modbus RTU Analog Output 8CH (B); unit 2: Waveshare "
      "Modbus RTU Analog Input 8CH (B)";
  CHECK(served_by({}, true) == std::vector<std::string>{module, line, reports, frames, stage, net, page, digital});
}

TEST_CASE("simulated rig: the digital force sensor's calibration and its gauges") {
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
  CHECK(fmt::format("{:.6g}", fmt::join(reading.raw, " ")) == "141 284 -10799 584 739 903");
  CHECK(fmt::format("{:.4f}", reading.wrench.force_n[2]) == "-25.0044");
}

TEST_CASE("simulated rig: its folder of sockets is gone with it") {
  std::string folder;
  {
    bench::BenchConfig config = small_request().bench;
    devices::TurnedClock clock;
    const bench::SimulatedRig rig(config, clock, false);
    folder = std::filesystem::path(config.scanner_socket).parent_path();
    CHECK(std::filesystem::is_directory(folder));
    CHECK((std::filesystem::status(folder).permissions() & std::filesystem::perms::all) ==
          std::filesystem::perms::owner_all);
  }
  CHECK_FALSE(std::filesystem::exists(folder));
}
