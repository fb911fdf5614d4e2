// The second platform in the plant: what the array and the force sensor see of an object under the z stage.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <vector>

#include "bench/simulation/plant.h"
#include "tests/bench/simulation/small_plant.h"

namespace tactbench::bench {
namespace {

using devices::Axis;
using devices::Nanoseconds;
using namespace std::chrono_literals;

using Counts = std::array<std::uint16_t, 256>;

struct Platform {
  explicit Platform(const PlantOptions& options = {}) : plant(options, clock), stage(clock) { plant.set_stage(&stage); }
  void move(Axis axis, double mm) { clock.wait_until(stage.go(axis, mm)); }
  void wait(Nanoseconds time) { clock.wait_until(clock.now() + time); }
  void over_the_centre() {
    move(Axis::kX, 30.0);
    move(Axis::kY, 30.0);
    move(Axis::kZ, 29.9);
  }
  // Goes on in small moves until the force is there.
  void press_to(double newtons) {
    const double sign = plant.true_force().value() < newtons ? 1.0 : -1.0;
    for (double z = stage.position(Axis::kZ).value(); sign * plant.true_force().value() < sign * newtons;) {
      z += sign * 0.005;
      move(Axis::kZ, z);
    }
  }
  Counts scan() {
    Counts counts{};
    std::array<std::uint8_t, 16> status{};
    plant.scan(counts, status);
    return counts;
  }
  devices::ManualClock clock;
  Plant plant;
  LoneStage stage;
};

double volts(std::uint16_t count) { return count * ScannerFrontEnd().volts_per_count; }

double mean(const Counts& counts) {
  double sum = 0.0;
  for (const auto count : counts) sum += volts(count);
  return sum / 256.0;
}

double deviation_of_full_scale(const Counts& counts) {
  double squares = 0.0;
  for (const auto count : counts) squares += std::pow(volts(count) - mean(counts), 2);
  return std::sqrt(squares / 256.0) / 3.49;
}

}  // namespace

TEST_CASE("plant: the array shows the ring and its hole, growing with force") {
  Platform rig;
  rig.over_the_centre();
  const Counts free = rig.scan();
  CHECK(mean(free) < 0.03);
  std::vector<double> up, down;
  std::vector<double> spread;
  for (const double force : {2.0, 6.0, 10.0, 20.0, 30.0}) {
    rig.press_to(force);
    rig.wait(2s);
    up.push_back(mean(rig.scan()));
    spread.push_back(deviation_of_full_scale(rig.scan()));
  }
  const Counts full = rig.scan();
  const auto psi = rig.plant.true_contact_psi();
  for (std::size_t i = 0; i < 256; ++i) {
    if (psi[i] > 20.0) CHECK(volts(full[i]) > 1.0);
    if (psi[i] < 0.01) CHECK(volts(full[i]) < 0.03);
  }
  CHECK(volts(full[7 * 16 + 7]) < 0.1);
  CHECK(*std::max_element(psi.begin(), psi.end()) > 28.0);
  for (const double force : {20.0, 10.0, 6.0, 2.0}) {
    rig.press_to(force);
    rig.wait(2s);
    down.push_back(mean(rig.scan()));
  }
  CHECK(std::is_sorted(up.begin(), up.end()));
  CHECK(std::is_sorted(spread.begin(), spread.end()));
  CHECK(down[1] > 1.1 * up[2]);  // the film's hysteresis
}

TEST_CASE("plant: the force sensor reads the object force, with relaxation at a held position and noise") {
  Platform rig;
  rig.over_the_centre();
  CHECK(rig.plant.wrench().force_n[2] == Approx(0.0).margin(0.03));
  rig.press_to(10.0);
  const double first = rig.plant.true_force().value();
  CHECK(rig.plant.wrench().force_n[2] == Approx(-first).margin(0.03));
  CHECK(rig.plant.wrench().force_n[2] != rig.plant.wrench().force_n[2]);
  rig.wait(60s);
  const double later = rig.plant.true_force().value();
  CHECK(later < 0.99 * first);
  CHECK(later > 0.93 * first);
  rig.plant.set_stage(nullptr);
  CHECK(rig.plant.true_force().value() == 0.0);
}

TEST_CASE("plant: a touch between two queries is not lost, and further queries change nothing") {
  const auto run = [](bool touch, int questions) {
    Platform rig;
    rig.over_the_centre();
    const Nanoseconds start = rig.clock.now();
    if (touch) {
      rig.move(Axis::kZ, 31.0);
      for (int i = 0; i < questions; ++i) {
        (void)rig.plant.wrench();
        (void)rig.plant.specimen_state();
        rig.wait(500ms / questions);
      }
      if (questions == 0) rig.wait(500ms);
      rig.move(Axis::kZ, 29.0);
    }
    rig.clock.wait_until(start + 10s);
    return rig.plant.specimen_state();
  };
  CHECK(run(true, 0) != run(false, 0));
  CHECK(run(true, 0) == run(true, 5));
  CHECK(run(true, 0) == run(true, 50));
}

TEST_CASE("plant: a stage without contact does not change the counts") {
  const auto run = [](bool with_stage) {
    devices::ManualClock clock;
    Plant plant(PlantOptions(), clock);
    LoneStage stage(clock);
    if (with_stage) plant.set_stage(&stage);
    Counts counts{};
    std::array<std::uint8_t, 16> status{};
    for (const double volts : {1.0, 4.0, 2.0}) {
      plant.drive(devices::Volts(volts), Nanoseconds::max(), devices::Volts(0.0));
      if (with_stage) stage.go(Axis::kZ, 5.0 * volts);
      clock.wait_until(clock.now() + 3s);
    }
    plant.scan(counts, status);
    return std::pair{counts, plant.specimen_state()};
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("plant: chamber pressure and object load add up") {
  const auto run = [](bool pressure, bool object) {
    Platform rig;
    rig.over_the_centre();
    if (object) rig.move(Axis::kZ, 30.5);
    rig.plant.drive(devices::Volts(pressure ? 0.5 : 0.0), Nanoseconds::max(), devices::Volts(0.0));
    rig.wait(3s);
    return rig.scan();
  };
  const Counts both = run(true, true);
  const Counts chamber = run(true, false);
  const Counts object = run(false, true);
  const auto highest = static_cast<std::size_t>(std::max_element(object.begin(), object.end()) - object.begin());
  CHECK(volts(both[highest]) > volts(object[highest]) + 0.1);
  CHECK(volts(both[highest]) > volts(chamber[highest]) + 0.1);
  CHECK(volts(both[0]) == Approx(volts(chamber[0])).margin(0.02));
}

}  // namespace tactbench::bench
