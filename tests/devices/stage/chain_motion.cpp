// Motion of the simulated device by the clock: when and where it is, what it reports meanwhile, how an axis sticks.
#include <catch2/catch.hpp>

#include "tests/devices/stage/chain_bench.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

constexpr double kLaStep = 0.00635 / 64;

// At home; moves at 4800 x 9.375 = 45000 steps/s and 4 x 11250 = 45000 steps/s^2: a ramp takes 1 s and 22500 steps.
struct EvenBench : ChainBench {
  EvenBench() {
    home();
    send(kTargetSpeed, 4800);
    send(kHomeSpeed, 4800);
    send(kAcceleration, 4);
  }
  // In steps, at a time after `begin`.
  double place(Nanoseconds time) { return device.position(time).value() / kLaStep; }
};

}  // namespace

TEST_CASE("simulated Zaber device: a move follows its ramps and ends at its computed time") {
  EvenBench bench;
  const Nanoseconds begin = bench.now;
  CHECK_FALSE(bench.device.due().has_value());
  bench.send(kMoveAbsolute, 90000);
  CHECK(bench.device.due() == begin + 3s);
  CHECK(bench.pass(1s).empty());
  CHECK(bench.read(kPosition) == 22500);
  CHECK(bench.pass(500ms).empty());
  CHECK(bench.read(kPosition) == 45000);
  bench.ends_after(1500ms, {1, kMoveAbsolute, 90000, 5});
  CHECK_FALSE(bench.device.due().has_value());
  CHECK(bench.place(begin + 500ms) == Approx(5625));
  CHECK(bench.place(begin + 2500ms) == Approx(84375));
  CHECK(bench.place(begin - 1s) == Approx(0.0).margin(1e-9));
  bench.send(kMoveRelative, -90000);
  CHECK(bench.device.due() == begin + 6s);
  bench.pass(1s);
  CHECK(bench.read(kPosition) == 67500);
}

TEST_CASE("simulated Zaber device: an acceleration of 0 is the highest acceleration") {
  EvenBench bench;
  const std::int32_t resolution = GENERATE(64, 32);
  bench.send(kResolution, resolution);
  bench.send(kAcceleration, 0);
  bench.send(kMoveAbsolute, 45000);
  // One second at its speed, and a ramp of 45000 / (11250 x 32767 or 16383) s.
  const Nanoseconds ramp = resolution == 64 ? 122074ns : 244156ns;
  REQUIRE(bench.device.due().has_value());
  CHECK(*bench.device.due() - bench.now - 1s - ramp >= 0ns);
  CHECK(*bench.device.due() - bench.now - 1s - ramp <= 2ns);
}

TEST_CASE("simulated Zaber device: a speed setting of 0 is the lowest speed") {
  EvenBench bench;
  bench.send(kTargetSpeed, GENERATE(0, 1));
  bench.send(kHomeSpeed, GENERATE(0, 1));
  for (const auto& [command, data] : {std::pair(kMoveAbsolute, 75), std::pair(kHome, 0)}) {
    bench.send(command, data);
    REQUIRE(bench.device.due().has_value());
    // 75 steps at 9.375 per second, and ramps of 0.2 ms.
    CHECK(*bench.device.due() - bench.now >= 8s);
    CHECK(*bench.device.due() - bench.now <= 8001ms);
    bench.pass(9s);
  }
}

TEST_CASE("simulated Zaber device: constant speed has its own value to either end, and is answered at once") {
  EvenBench bench;
  bench.send(kTargetSpeed, 100);
  bench.send(kMaximumPosition, 90000);
  CHECK(bench.send(kConstantSpeed, 4800) == std::vector<ZaberFrame>{{1, kConstantSpeed, 4800, 5}});
  CHECK(bench.device.due() == bench.now + 3s);
  bench.ends_after(3s, {1, kLimitActive, 90000, 0});
  CHECK(bench.send(kConstantSpeed, -4800) == std::vector<ZaberFrame>{{1, kConstantSpeed, -4800, 5}});
  CHECK(bench.device.due() == bench.now + 3s);
  bench.pass(1500ms);
  CHECK(bench.read(kPosition) == 45000);
  CHECK(bench.send(kConstantSpeed, 0) == std::vector<ZaberFrame>{{1, kConstantSpeed, 0, 5}});
  CHECK(bench.device.due() == bench.now + 1s);
  bench.pass(1s);
  CHECK(bench.read(kPosition) == 22500);
  CHECK(bench.read(kStatus) == 0);
  bench.send(kConstantSpeed, 1);
  CHECK(bench.pass(8s).empty());
  CHECK(bench.read(kPosition) == 22575);  // 9.375 a second
  bench.send(kConstantSpeed, -1);
  bench.pass(8s);
  CHECK(bench.read(kPosition) == 22500);
}

TEST_CASE(
    "simulated Zaber device: a stop uses the set acceleration, a relative move starts from the present position") {
  EvenBench bench;
  bench.send(kMoveAbsolute, 500000);
  bench.pass(2s);
  CHECK(bench.read(kPosition) == 67500);
  bench.send(kStop, 0);
  CHECK(bench.device.due() == bench.now + 1s);
  CHECK(bench.pass(1s) == std::vector<ZaberFrame>{{1, kStop, 90000, 5}});
  bench.send(kMoveAbsolute, 500000);
  bench.pass(1s);
  bench.send(kMoveRelative, 45000);  // from 112500: 22500 at its speed, 22500 to rest
  CHECK(bench.device.due() == bench.now + 1500ms);
  CHECK(bench.pass(1500ms) == std::vector<ZaberFrame>{{1, kMoveRelative, 157500, 5}});
}

TEST_CASE("simulated Zaber device: homing ends at its sensor or its home offset, where the counter is 0") {
  EvenBench bench;
  bench.go_to(90000);
  bench.send(kSetPosition, 1000);
  bench.send(kMode, 0);
  bench.send(kHome, 0);
  CHECK(bench.device.due() == bench.now + 3s);
  CHECK(bench.pass(3s - 1ns).empty());
  CHECK(bench.setting(kMode) == 0);
  CHECK(bench.pass(1ns) == std::vector<ZaberFrame>{{1, kHome, 0, 5}});
  CHECK(bench.setting(kMode) == kZaberHomed);
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
  bench.send(kHomeOffset, 100);
  bench.moves(kHome, 0, 0);
  CHECK(bench.place(bench.now) == Approx(100.0));
  // Homing from a motion begins with this motion.
  bench.send(kMoveAbsolute, 500000);
  bench.pass(1s);
  bench.send(kHome, 0);
  bench.pass(1s);
  CHECK(bench.place(bench.now) == Approx(100.0 + 22500 + 22500));
}

TEST_CASE("simulated Zaber device: with move tracking it reports its position every 0.25 s until the move ends") {
  EvenBench bench;
  bench.send(kMode, kZaberMoveTracking | kZaberHomed);
  bench.send(kMoveAbsolute, 90000);
  const Nanoseconds begin = bench.now;
  bench.ends_after(250ms, {1, kMoveTracking, 1406, 0});
  CHECK(bench.device.due() == begin + 500ms);
  CHECK(bench.pass(500ms) == std::vector<ZaberFrame>{{1, kMoveTracking, 5625, 0}, {1, kMoveTracking, 12656, 0}});
  const auto rest = bench.pass(10s);
  REQUIRE(rest.size() == 10);
  CHECK(rest[0] == ZaberFrame{1, kMoveTracking, 22500, 0});
  CHECK(rest[8] == ZaberFrame{1, kMoveTracking, 90000, 0});
  CHECK(rest[9] == ZaberFrame{1, kMoveAbsolute, 90000, 5});
  CHECK(bench.pass(10s).empty());
  // 0.4 s: the end comes before the second report.
  bench.send(kMoveRelative, 1800);
  CHECK(bench.pass(250ms).size() == 1);
  CHECK(bench.device.due() == bench.now + 150ms);
  CHECK(bench.pass(10s) == std::vector<ZaberFrame>{{1, kMoveRelative, 91800, 5}});
}

TEST_CASE("simulated Zaber device: is at rest from the end of its motion on") {
  EvenBench bench;
  ChainBench fresh;
  CHECK(fresh.device.at_rest_since(0ns));
  fresh.device.free(5s);  // it does not stick
  CHECK(fresh.device.at_rest_since(0ns));
  const Nanoseconds begin = bench.now;
  CHECK(bench.device.at_rest_since(begin));
  bench.send(kMoveAbsolute, 90000);
  CHECK_FALSE(bench.device.at_rest_since(begin - 1ns));
  CHECK_FALSE(bench.device.at_rest_since(begin));
  CHECK_FALSE(bench.device.at_rest_since(begin + 3s - 1ns));
  CHECK(bench.device.at_rest_since(begin + 3s));
  bench.pass(1s);
  bench.device.stick(bench.now);
  CHECK_FALSE(bench.device.at_rest_since(bench.now - 1ns));
  CHECK(bench.device.at_rest_since(bench.now));
}

TEST_CASE(
    "simulated Zaber device: a stuck axis stays while the counter advances, and continues from there when freed") {
  EvenBench bench;
  const Nanoseconds begin = bench.now;
  bench.send(kMoveAbsolute, 90000);
  bench.pass(1s);
  bench.device.stick(bench.now);
  bench.pass(500ms);
  CHECK(bench.read(kPosition) == 45000);
  CHECK(bench.place(bench.now) == Approx(22500));
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(22500));
  CHECK(bench.pass(1500ms) == std::vector<ZaberFrame>{{1, kMoveAbsolute, 90000, 5}});
  CHECK(bench.place(bench.now) == Approx(67500));
  CHECK(bench.place(begin + 500ms) == Approx(5625));
  CHECK(bench.place(begin + 1200ms) == Approx(22500));
  CHECK(bench.place(begin + 2s) == Approx(45000));
  // Missed steps add to those missed before.
  bench.device.stick(bench.now);
  CHECK(bench.place(bench.now) == Approx(67500));
  bench.go_to(0);
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(67500));
  bench.send(kHome, 0);
  CHECK(bench.pass(60s) == std::vector<ZaberFrame>{{1, kHome, 0, 5}});
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
}

TEST_CASE("simulated Zaber device: homing of a stuck axis ends only after it is freed") {
  EvenBench bench;
  bench.go_to(90000);
  bench.device.stick(bench.now);
  bench.send(kHome, 0);
  CHECK(bench.pass(1h).empty());
  CHECK(bench.read(kStatus) == 1);
  CHECK(bench.place(bench.now) == Approx(90000));
  bench.device.free(bench.now);
  CHECK(bench.place(bench.now) == Approx(90000));
  CHECK(bench.device.due() == bench.now + 3s);
  bench.ends_after(3s, {1, kHome, 0, 5});
  CHECK(bench.place(bench.now) == Approx(0.0).margin(1e-9));
  CHECK(bench.read(kPosition) == 0);
  // Other moves of an axis that sticks end as if it moved.
  bench.device.stick(bench.now);
  bench.send(kMoveAbsolute, 90000);
  CHECK(bench.pass(3s) == std::vector<ZaberFrame>{{1, kMoveAbsolute, 90000, 5}});
  bench.device.free(bench.now);
  CHECK_FALSE(bench.device.due().has_value());
}

TEST_CASE("simulated Zaber device: remembers its last 256 changes of motion, and the position before them") {
  ChainBench bench;
  bench.home();  // the first change
  const double homing = bench.device.position(1s).value() / kLaStep;
  CHECK(homing > 10000);
  const auto middle_of = [&](std::int32_t target) {
    bench.send(kMoveAbsolute, target);
    bench.pass(10s);
    return bench.now - 5s;  // it is at rest there by then
  };
  const Nanoseconds first = middle_of(5000);
  const Nanoseconds second = middle_of(1000);
  for (std::int32_t i = 3; i < 256; ++i) middle_of(1000 + i);
  const auto steps_at = [&](Nanoseconds time) { return bench.device.position(time).value() / kLaStep; };
  CHECK(steps_at(1s) == Approx(homing));
  middle_of(2000);  // the 257th change, then the 258th: the motion to its home is forgotten
  CHECK(steps_at(1s) == Approx(homing));
  middle_of(3000);
  CHECK(steps_at(1s) == Approx(0.0).margin(1e-9));
  CHECK(steps_at(30s) == Approx(0.0).margin(1e-9));
  CHECK(steps_at(first) == Approx(5000));
  middle_of(2000);
  CHECK(steps_at(first) == Approx(5000));
  CHECK(steps_at(30s) == Approx(5000));
  CHECK(steps_at(second) == Approx(1000));
}
