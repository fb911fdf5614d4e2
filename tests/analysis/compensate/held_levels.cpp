// Fast compensators beside their plain forms where outputs are held, so that they are averaged, and leave their level
// again: on films of one line in every figure, on films with hysteresis in the pressure, and in the uncertainty within
// what the fast forms take for granted.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/compensate/straight_setup.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

constexpr double kNoiseV = 0.01, kVoltsACount = 1e-4;
const double kWholeNoiseV = std::hypot(kNoiseV, kVoltsACount / std::sqrt(12.0));

// Each level as often as an output needs to count as still and to be averaged, with noise; the way between in steps.
template <class LevelNoise>
std::vector<double> held_walk(const std::vector<double>& levels, double step, const LevelNoise& noise) {
  std::vector<double> way;
  double at = levels.front();
  for (const double level : levels) {
    while (std::abs(level - at) > step) way.push_back((at += level > at ? step : -step) + noise());
    at = level;
    for (int i = 0; i < 60; ++i) way.push_back(at + noise());
  }
  return way;
}

// Jumps, ways in small steps, turns within the noise and beyond it.
std::vector<double> held_volts(double first) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, kNoiseV);
  return held_walk({first, 1.0, 0.985, 1.01, 0.95, 0.9, 1.0, 2.5, 2.49, 2.47, 2.5, 1.5, 1.51, 1.53, 1.5, 2.0, 0.6, 0.5},
                   0.007, [&] { return normal(random); });
}

ElamModel model_of_volts(const std::vector<double>& up, const std::vector<double>& down, double beta_d) {
  const std::vector<double> pressure{0.0, 30.0, 60.0};
  return {
      PatternCurve(pressure, up, 0.0, 3.0), PatternCurve(pressure, down, 0.0, 3.0), {0.5, beta_d, 0.0, 0.5, 0.5}, {}};
}

FrameSetup setup_of_model(const ElamModel& model, bool unknown) {
  FrameSetup setup;
  const auto up = model.ascending.y(), down = model.descending.y();
  setup.pressure_psi = {0.0, 30.0, 60.0};
  setup.taxels.push_back({true, {up.begin(), up.end()}, {down.begin(), down.end()}, model.parameters, kNoiseV, false});
  setup.volts_per_count = kVoltsACount;
  setup.options.drift_share = 0.0;
  setup.start_unknown = unknown;
  return setup;
}

// What an array of one taxel read of a sample.
struct FastReading {
  double pressure = 0.0, uncertainty = 0.0;
  int status = 0;
};
template <class Fast>
FastReading fast_reading(Fast& fast, double volts) {
  std::vector<double> pressure(1), uncertainty(1);
  std::vector<std::uint16_t> status(1);
  const std::vector<double> samples{volts};
  fast.frame(std::span<const double>(samples), {pressure, uncertainty, status});
  return {pressure[0], uncertainty[0], status[0]};
}

void check_marks(const FastReading& fast, const Compensated& plain) {
  CHECK(((fast.status & kTaxelUnknown) != 0) == plain.unknown);
  CHECK(((fast.status & kTaxelOutOfRange) != 0) == plain.out_of_range);
}

// Of the uncertainties of one form over those of the other.
struct Ratios {
  double least = 1e9, most = 0.0, sum = 0.0, count = 0.0;
  void add(double fast, double plain) {
    least = std::min(least, fast / plain);
    most = std::max(most, fast / plain);
    sum += fast / plain;
    count += 1.0;
  }
};

// Films of one line: each figure is that of the plain form; `zero` is the output without load, and some outputs are
// flat and some averaged to less than `averaged_psi`.
template <class Fast, class PlainStep>
void check_every_figure(Fast& fast, const PlainStep& plain_step, bool unknown, double zero, double averaged_psi) {
  int flat = 0, averaged = 0;
  for (const double above : held_volts(unknown ? 1.2 : 0.3)) {
    const FastReading now = fast_reading(fast, zero + above);
    const Compensated one = plain_step(zero + above);
    CHECK(now.pressure == Approx(one.pressure_psi).margin(1e-9));
    CHECK(now.uncertainty == Approx(one.uncertainty_psi).epsilon(1e-6));
    CHECK(((now.status & kTaxelFlat) != 0) == one.flat);
    check_marks(now, one);
    flat += one.flat ? 1 : 0;
    averaged += one.uncertainty_psi < averaged_psi ? 1 : 0;
  }
  CHECK(flat > 100);
  CHECK(averaged > 50);
}

}  // namespace

TEST_CASE("held outputs of ELAM on one line: pressure, uncertainty and marks are those of the plain form") {
  const ElamModel model = model_of_volts({0.0, 1.5, 3.0}, {0.0, 1.5, 3.0}, 0.5);
  for (const bool unknown : {false, true}) {
    FrameSetup setup = setup_of_model(model, unknown);
    CompensatorOptions options = setup.options;
    options.noise_v = kWholeNoiseV;
    // Of means of up to eight noises; with the lower limit some are flat, and some not.
    setup.options.flat_psi = options.flat_psi = 0.5;
    FrameCompensator<double> fast(setup);
    TaxelCompensator plain(model, options);
    if (unknown) plain.reset_unknown();
    check_every_figure(
        fast, [&](double volts) { return plain.step(volts); }, unknown, 0.0, 0.5 * 20.0 * kNoiseV);
  }
}

TEST_CASE("held outputs of ELAM with hysteresis: the plain form's pressure, and its uncertainty or a little more") {
  const ElamModel model = model_of_volts({0.0, 1.2, 3.0}, {0.0, 2.0, 3.0}, 2.0 / 3.0);
  for (const bool unknown : {false, true}) {
    const FrameSetup setup = setup_of_model(model, unknown);
    CompensatorOptions options = setup.options;
    options.noise_v = kWholeNoiseV;
    FrameCompensator<double> fast(setup);
    TaxelCompensator plain(model, options);
    if (unknown) plain.reset_unknown();
    Ratios ratios;
    for (const double volts : held_volts(unknown ? 1.2 : 0.3)) {
      const FastReading now = fast_reading(fast, volts);
      const Compensated one = plain.step(volts);
      CHECK(now.pressure == Approx(one.pressure_psi).margin(1e-9));
      check_marks(now, one);
      ratios.add(now.uncertainty, one.uncertainty_psi);
      // A history that is not known is read as the plain form reads it, without tables.
      if (one.unknown) CHECK(now.uncertainty == Approx(one.uncertainty_psi).epsilon(1e-6));
    }
    CAPTURE(unknown, ratios.least, ratios.most, ratios.sum / ratios.count);
    CHECK(ratios.least > 0.7);
    CHECK(ratios.most < 2.01);  // at the kink its two slopes differ by a factor of two
    CHECK(ratios.sum / ratios.count == Approx(1.07).margin(0.03));
  }
}

namespace {

DynamicSetup line_film(bool unknown) {
  DynamicSetup setup = straight_setup(kNoiseV);
  setup.start_unknown = unknown;
  return setup;
}

}  // namespace

TEST_CASE("held outputs of a dynamic film of one line: every figure is that of the plain form", "[dynamic]") {
  for (const bool unknown : {false, true}) {
    DynamicSetup setup = line_film(unknown);
    setup.residual_psi = {0.03, 0.05};
    setup.taxels[0].residual_scale = 2.0;
    setup.options.flat_psi = 0.25;
    const DynamicSetup plain_setup = with_rounding(setup);
    DynamicFrameCompensator<double> fast(setup);
    DynamicTaxelCompensator plain(plain_setup, 0);
    if (unknown) plain.reset_unknown();
    check_every_figure(
        fast, [&](double volts) { return plain.step(volts, 0.0); }, unknown, 0.5, 0.09);
  }
}

TEST_CASE("held outputs of dynamic films with hysteresis: the plain form's pressure, known and unknown start",
          "[dynamic]") {
  for (const bool unknown : {false, true}) {
    DynamicSetup setup = dynamic_array(1, kNoiseV, 8).setup;
    const PreisachModel film = film_of(1, 8);
    setup.start_unknown = unknown;
    setup.dynamics.creep_share = {};
    setup.taxels[0].lag_share = 0.0;
    setup.volts_per_count = kVoltsACount;
    const DynamicSetup plain_setup = with_rounding(setup);
    DynamicFrameCompensator<double> fast(setup);
    DynamicTaxelCompensator plain(plain_setup, 0);
    if (unknown) plain.reset_unknown();
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0.0, kNoiseV);
    DynamicPlant plant(film, setup.dynamics, setup.taxels[0], 1);
    Ratios ratios;
    for (const double psi :
         held_walk({unknown ? 24.0 : 0.0, 20.0, 19.7, 20.2, 19.0, 45.0, 44.8, 45.3, 44.0, 30.0, 30.2, 29.8, 31.0, 10.0},
                   0.15, [] { return 0.0; })) {
      const double volts = plant.step(psi, 1.0) + normal(random);
      const FastReading now = fast_reading(fast, volts);
      const Compensated one = plain.step(volts, 0.0);
      CHECK(now.pressure == Approx(one.pressure_psi).margin(1e-7));
      check_marks(now, one);
      if (now.pressure > 1.0)
        ratios.add(now.uncertainty, one.uncertainty_psi);  // below, a piece without a slope begins
    }
    CAPTURE(unknown, ratios.least, ratios.most, ratios.sum / ratios.count);
    CHECK(ratios.least > 0.4);
    CHECK(ratios.most < 2.5);
    CHECK(ratios.sum / ratios.count == Approx(1.05).margin(0.1));
  }
}

TEST_CASE("fast compensators without a flat criterion: noise times the slope, and nothing hidden behind a turn",
          "[dynamic]") {
  DynamicSetup setup = line_film(false);
  setup.options.flat_in_noises = 0.0;
  DynamicFrameCompensator<double> fast(setup);
  for (const double volts : {2.5, 2.5, 2.499, 2.498, 2.5}) {
    const FastReading now = fast_reading(fast, volts);
    CHECK(now.uncertainty == Approx(10.0 * kWholeNoiseV));
    CHECK((now.status & kTaxelFlat) == 0);
  }
  FrameSetup elam = setup_of_model(model_of_volts({0.0, 1.5, 3.0}, {0.0, 1.5, 3.0}, 0.5), false);
  elam.options.flat_in_noises = 0.0;
  FrameCompensator<double> other(elam);
  for (const double volts : {1.0, 1.0, 0.999})
    CHECK(fast_reading(other, volts).uncertainty == Approx(0.0).margin(1e-9));
}

TEST_CASE("a dynamic array's lost frames: creep and lag go on at the last pressure, which is held with its uncertainty",
          "[dynamic]") {
  // The film is creeping and late; while frames are lost it stays under its pressure.
  DynamicSetup setup = line_film(false);
  setup.taxels[0].noise_v = 0.0;
  setup.volts_per_count = 1e-9;
  setup.dynamics.creep_s = {2.0, 20.0, 200.0};
  setup.dynamics.creep_share = {0.05, 0.03, 0.02};
  setup.dynamics.creep_half = 20.0;
  setup.dynamics.lag_s = 1.5;
  setup.taxels[0].creep_scale = 1.5;
  setup.taxels[0].lag_share = 0.2;
  setup.residual_psi = {0.3, 0.4};
  setup.longest_gap = 3;
  DynamicFrameCompensator<double> fast(setup);
  fast.set_interval(0.5);
  DynamicsState state;
  const auto volts_at = [&](double psi) {
    const DynamicsStep step(setup.dynamics, 0.5);
    const double out = arrived(0.2, state, step, psi) / 10.0 * creep_factor(setup.dynamics, state, step, psi, 1.5);
    advance(setup.dynamics, state, step, psi);
    return 0.5 + out;
  };
  std::vector<double> pressure(1), uncertainty(1);
  std::vector<std::uint16_t> status(1);
  for (const double psi : {0.0, 10.0, 20.0, 30.0, 30.0})
    CHECK(fast_reading(fast, volts_at(psi)).pressure == Approx(psi).margin(0.02));
  for (int lost = 0; lost < 3; ++lost) {
    (void)volts_at(30.0);
    fast.lost_frame({pressure, uncertainty, status});
    CHECK(pressure[0] == Approx(30.0).margin(0.02));
    CHECK(uncertainty[0] == Approx(0.3).epsilon(1e-3));
    CHECK(status[0] == kTaxelLost);
  }
  for (const double psi : {30.0, 40.0, 15.0, 15.0})
    CHECK(fast_reading(fast, volts_at(psi)).pressure == Approx(psi).margin(0.05));
  // A frame in between: the gap is counted anew; the fourth in a row is one too many.
  for (int lost = 0; lost < 4; ++lost) {
    fast.lost_frame({pressure, uncertainty, status});
    CHECK(status[0] == (lost < 3 ? kTaxelLost : (kTaxelLost | kTaxelUnknown)));
  }
}
