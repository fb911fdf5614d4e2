#include "bench/simulation/plant.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "devices/tactile/scan_report.h"

namespace tactbench::bench {
namespace {

using devices::Nanoseconds;
using devices::Volts;
using namespace std::chrono_literals;

constexpr Nanoseconds kForever = Nanoseconds::max();

Volts plant_volts_for(double psi) { return Volts(psi / ChamberOptions().span_psi * 10.0); }
double psi_of_reference(Volts volts) { return volts.value() / 10.0 * ChamberOptions().reference_span_psi; }
double psi_of_feedback(Volts volts) { return volts.value() / 10.0 * ChamberOptions().span_psi; }

struct Scan {
  std::array<std::uint16_t, 256> counts{};
  std::array<std::uint8_t, 16> status{};
};

Scan scan(Plant& plant) {
  Scan result;
  plant.scan(result.counts, result.status);
  return result;
}

double mean_volts(const Scan& scan, const ScannerFrontEnd& front = {}) {
  double sum = 0.0;
  for (const auto count : scan.counts) sum += count * front.volts_per_count;
  return sum / 256.0;
}

struct PlantRig {
  // NOLINTNEXTLINE(clang-analyzer-optin*): it loses sight of the copied options
  explicit PlantRig(const PlantOptions& options = PlantOptions()) : plant(options, clock) {}
  void wait(Nanoseconds time) { clock.wait_until(clock.now() + time); }
  void hold(double psi, Nanoseconds time) {
    plant.drive(plant_volts_for(psi), kForever, Volts(0.0));
    wait(time);
  }
  devices::TurnedClock clock;
  Plant plant;
};

}  // namespace

TEST_CASE("plant: pressure, feedback and reference follow the command") {
  PlantRig rig;
  CHECK(rig.plant.true_pressure().value() == 0.0);
  rig.hold(30.0, 3s);
  const double truth = rig.plant.true_pressure().value();
  CHECK(truth == Approx(30.0).margin(0.25));
  CHECK(psi_of_reference(rig.plant.reference()) == Approx(truth).margin(0.05));
  CHECK(psi_of_feedback(rig.plant.feedback()) == Approx(30.0).margin(0.11));
  CHECK(psi_of_reference(rig.plant.reference()) != psi_of_reference(rig.plant.reference()));  // noise
}

TEST_CASE("plant: noise of both transducers is as stated") {
  PlantOptions options;
  PlantRig rig(options);
  rig.hold(40.0, 5s);
  const double truth = rig.plant.true_pressure().value();
  double reference = 0.0;
  double feedback = 0.0;
  constexpr int kReadings = 4000;
  for (int i = 0; i < kReadings; ++i) {
    reference += std::pow(psi_of_reference(rig.plant.reference()) - truth, 2);
    feedback += psi_of_feedback(rig.plant.feedback());
  }
  CHECK(std::sqrt(reference / kReadings) == Approx(options.chamber.reference_noise_psi).epsilon(0.05));
  CHECK(feedback / kReadings == Approx(40.0).margin(0.02));
}

TEST_CASE("plant: the watchdog's fallback takes over at its own time, at any time of the query") {
  const auto pressure_after = [](Nanoseconds hold, bool ask_often) {
    PlantRig rig;
    rig.plant.drive(plant_volts_for(20.0), hold, plant_volts_for(0.0));
    for (int i = 0; i < 300; ++i) {
      rig.wait(10ms);
      if (ask_often) static_cast<void>(rig.plant.true_pressure());
    }
    return rig.plant.true_pressure().value();
  };
  CHECK(pressure_after(kForever, false) == Approx(20.0).margin(0.25));
  CHECK(pressure_after(1s, false) == Approx(0.0).margin(1e-3));
  // The limit itself counts, not the grid: read while the pressure still falls.
  const double early = pressure_after(2900ms, false);
  const double late = pressure_after(2903ms, false);
  CHECK(early > 0.5);
  CHECK(late > early + 0.05);
  CHECK(pressure_after(2907ms, false) > late + 0.05);  // within one cell of the grid
  CHECK(pressure_after(2903ms, true) == late);
}

TEST_CASE("plant: a drive whose limit has passed drives the fallback at once") {
  PlantRig rig;
  rig.hold(20.0, 3s);
  rig.plant.drive(plant_volts_for(40.0), rig.clock.now() - 1ms, plant_volts_for(0.0));
  rig.wait(3s);
  CHECK(rig.plant.true_pressure().value() == Approx(0.0).margin(1e-6));
}

TEST_CASE("plant: neither feeding the watchdog nor queries change the plant") {
  const auto run = [](bool feed, bool ask) {
    PlantRig rig;
    rig.clock.wait_until(1234567ns);
    for (const double level : {10.0, 40.0, 24.0, 26.0}) {
      rig.plant.drive(plant_volts_for(level), kForever, Volts(0.0));
      for (int i = 0; i < 9; ++i) {
        rig.wait(287654321ns);
        if (feed) rig.plant.drive(plant_volts_for(level), kForever, Volts(0.0));
        if (ask) {
          static_cast<void>(rig.plant.true_pressure());
          static_cast<void>(rig.plant.feedback());
          static_cast<void>(rig.plant.specimen_state());
        }
      }
    }
    return std::pair{scan(rig.plant).counts, rig.plant.specimen_state()};
  };
  const auto quiet = run(false, false);
  CHECK(run(true, false) == quiet);
  CHECK(run(true, true) == quiet);
}

TEST_CASE("plant: same seeds, same answers, and another noise seed moves only the noise") {
  const auto run = [](std::uint64_t seed, std::uint64_t sensor) {
    PlantOptions options;
    options.seed = seed;
    options.specimen.sensor_seed = sensor;
    PlantRig rig(options);
    rig.hold(25.0, 3s);
    return scan(rig.plant).counts;
  };
  const auto one = run(1, 1);
  CHECK(run(1, 1) == one);
  const auto other_noise = run(2, 1);
  CHECK(other_noise != one);
  const auto other_sensor = run(1, 2);
  double noise = 0.0;
  double sensor = 0.0;
  for (std::size_t i = 0; i < 256; ++i) {
    noise += std::pow(one[i] - other_noise[i], 2) / 256;
    sensor += std::pow(one[i] - other_sensor[i], 2) / 256;
  }
  const ScannerFrontEnd front;
  CHECK(std::sqrt(noise / 2) * front.volts_per_count == Approx(front.noise_v).epsilon(0.15));
  CHECK(std::sqrt(sensor) > 50 * std::sqrt(noise));
}

TEST_CASE("plant: a relay that is not given its time mixes in the row before") {
  const auto at_settle = [](double settle_s) {
    PlantOptions options;
    options.scanner.noise_v = 0.0;
    options.scanner.relay_settle_s = settle_s;
    PlantRig rig(options);
    rig.hold(25.0, 3s);
    return scan(rig.plant);
  };
  const Scan settled = at_settle(1.0);
  const Scan shipped = at_settle(ScannerFrontEnd().relay_settle_s);
  const Scan hasty = at_settle(0.0006);  // one time constant: 1/e is left
  for (std::size_t r = 0; r < 16; ++r) {
    CHECK(shipped.status[r] == 0);
    CHECK(hasty.status[r] == devices::kStatusNotSettled);
    for (std::size_t c = 0; c < 16; ++c) {
      const double own = settled.counts[r * 16 + c];
      const double before = settled.counts[(r + 15) % 16 * 16 + c];
      REQUIRE(hasty.counts[r * 16 + c] == Approx(own + std::exp(-1.0) * (before - own)).margin(1.5));
      REQUIRE(shipped.counts[r * 16 + c] == Approx(own).margin(0.002 * 65535));
    }
  }
}

TEST_CASE("plant: no healthy taxel is at a limit, unloaded or at 60 psi") {
  PlantRig rig;
  for (const double level : {0.0, 60.0, 0.0}) {
    rig.hold(level, 5s);
    for (int k = 0; k < 10; ++k) {
      for (const auto status : scan(rig.plant).status) REQUIRE(status == 0);
    }
  }
}

TEST_CASE("plant: a noisy taxel is noisy at the counts") {
  PlantOptions options;
  options.specimen.defects = {{TaxelDefect::Kind::kNoisy, 9, 9}};
  PlantRig rig(options);
  rig.hold(30.0, 3s);
  double squares = 0.0;
  const double first = scan(rig.plant).counts[9 * 16 + 9];
  for (int k = 0; k < 200; ++k) squares += std::pow(scan(rig.plant).counts[9 * 16 + 9] - first, 2) / 200;
  CHECK(std::sqrt(squares) * options.scanner.volts_per_count > 0.03);
}

TEST_CASE("plant: the specimen's state moves from one plant to another") {
  PlantRig first;
  first.hold(60.0, 3s);
  first.hold(0.0, 3s);
  const std::string state = first.plant.specimen_state();
  PlantRig second;
  second.plant.set_specimen_state(state);
  CHECK(second.plant.specimen_state() == state);
  PlantRig fresh;
  second.hold(20.0, 3s);
  fresh.hold(20.0, 3s);
  CHECK(std::abs(mean_volts(scan(second.plant)) - mean_volts(scan(fresh.plant))) > 0.01);  // conditioned against new
  CHECK_THROWS_AS(second.plant.set_specimen_state("{}"), std::invalid_argument);
}

TEST_CASE("plant: the fixed grid agrees with a fine one over a sweep") {
  // A sweep 0-60-0 in 2 psi steps of 2.4 s; the same film moved at each 10 ms is the truth of the cutting.
  PlantRig rig;
  Specimen fine({});
  Chamber chamber({});
  double worst = 0.0;
  for (int step = 1; step <= 60; ++step) {
    const double level = step <= 30 ? 2.0 * step : 120.0 - 2.0 * step;
    rig.hold(level, 2400ms);
    const double coarse = mean_volts(scan(rig.plant));
    chamber.command(plant_volts_for(level));
    for (int i = 0; i < 240; ++i) {
      chamber.advance(0.01);
      fine.advance(chamber.pressure().value(), 0.01);
    }
    std::vector<double> volts(256);
    fine.output(volts);
    double mean = 0.0;
    for (const double v : volts) mean += v / 256;
    worst = std::max(worst, std::abs(mean - coarse));
  }
  CHECK(worst < 0.002);
}

}  // namespace tactbench::bench
