// The rig at its edges: what it refuses without an instrument, and that each exchange with each of them counts.
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/rig/rig.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const std::string kLineOfSensors =
    "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], span_c = [-100, "
    "100]}, "
    "{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]";

}  // namespace

TEST_CASE("rig: using a device that is not open or not present is a logic error") {
  bench::BenchConfig config = small_request().bench;
  {
    bench::Rig rig(config);
    CHECK_THROWS_AS(rig.array(), std::logic_error);
    CHECK_FALSE(rig.has_array());
    rig.open_array();
    CHECK(rig.array().rows() == 16);
    rig.close_array();
    CHECK_THROWS_AS(rig.array(), std::logic_error);
    CHECK(rig.force() == nullptr);
    CHECK(rig.relay_operations().empty());
    CHECK(rig.plant() != nullptr);
    CHECK(rig.dead_man() == nullptr);
  }
  bench::BenchConfig no_force = config, no_stage = config;
  no_force.force.reset();
  no_stage.stage.reset();
  bench::Rig without_force(no_force), without_stage(no_stage);
  CHECK_THROWS_AS(without_force.open_force(), std::logic_error);
  CHECK_THROWS_AS(without_force.name_press_instruments(), std::logic_error);
  CHECK(without_force.stage_gate() != nullptr);
  CHECK_THROWS_AS(without_stage.name_press_instruments(), std::logic_error);
  CHECK(without_stage.stage_gate() == nullptr);
}

TEST_CASE("rig: every exchange is counted, for each instrument") {
  bench::Rig rig(small_request({{"environment.sensor", kLineOfSensors}}).bench);
  rig.open();
  (void)rig.open_force();
  rig.stage_gate()->arm();
  const auto counted = [&](const std::function<void()>& exchange) {
    rig.clock().wait_until(rig.clock().now() +
                           std::chrono::milliseconds(100));  // an image of the module may be read twice
    const std::uint64_t before = rig.exchanges();
    exchange();
    return static_cast<std::int64_t>(rig.exchanges() - before);
  };
  CHECK(counted([] {}) == 0);
  CHECK(counted([&] { (void)rig.environment(0); }) == 1);
  CHECK(counted([&] { (void)rig.environment(); }) == 2);
  CHECK(counted([&] { (void)rig.reference().read(); }) > 0);
  CHECK(counted([&] { (void)rig.source().feedback(); }) > 0);
  CHECK(counted([&] { (void)rig.array().read(1); }) > 0);
  CHECK(counted([&] { (void)rig.stage_gate()->state(devices::Axis::kZ); }) > 0);
  CHECK(counted([&] { (void)rig.force()->read(10); }) > 0);
  CHECK(rig.environment(0).quantity == "temperature_c");
  CHECK(rig.environment(0).value == Approx(23.0).margin(0.11));
  CHECK(rig.environment(1).value == Approx(8.0));
}

TEST_CASE("rig: press instruments are recorded, and closed again if they were not open before") {
  bench::Rig rig(small_request().bench);
  const std::size_t before = rig.devices().size();
  rig.name_press_instruments();
  CHECK(rig.force() == nullptr);
  CHECK(rig.devices().size() == before + 4);  // three axes and the force sensor
  (void)rig.open_force();
  rig.name_press_instruments();
  CHECK(rig.force() != nullptr);
  CHECK(rig.devices().size() == before + 4);
  rig.open_array();
  REQUIRE(rig.devices().size() == before + 5);
  std::vector<std::string> roles;
  for (const db::DeviceRecord& device : rig.devices()) roles.push_back(device.role);
  CHECK(std::vector<std::string>(roles.end() - 5, roles.end()) ==
        std::vector<std::string>{"stage x", "stage y", "stage z", "force sensor", "tactile scanner"});
}
