// The plain compensator of one taxel by hand, on a loop without hysteresis of 20 psi a volt: means of samples, jumps,
// uncertainties, marks and the dead band; and on one with hysteresis, what hides behind the noise.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/compensate/compensator.h"

using namespace tactbench::analysis;

namespace {

// Both patterns are one line, and the split lies on it.
ElamModel taxel_of_one_line() {
  const std::vector<double> pressure{0.0, 30.0, 60.0}, volts{0.0, 1.5, 3.0};
  const PatternCurve line(pressure, volts, 0.0, 3.0);
  return {line, line, {0.5, 0.5, 0.0, 0.5, 0.5}, {}};
}

// Up 20 psi a volt. Down from the top 30 psi a volt to 30 psi at 2 V, then 15 psi a volt.
ElamModel bent_taxel() {
  const std::vector<double> pressure{0.0, 30.0, 60.0}, up{0.0, 1.5, 3.0}, down{0.0, 2.0, 3.0};
  return {PatternCurve(pressure, up, 0.0, 3.0),
          PatternCurve(pressure, down, 0.0, 3.0),
          {0.5, 2.0 / 3.0, 0.0, 0.5, 0.5},
          {}};
}

// Brought to 1 V and left there until its output counts as still: the mean square of the steps, 14 at most, falls by a
// 24th a sample, and is below 2.4 after 42 of them (14 x (23 / 24)^42 = 2.34).
TaxelCompensator still_at_one_volt(const ElamModel& model, double noise, int samples = 42) {
  TaxelCompensator compensator(model, {.noise_v = noise});
  for (int i = 0; i <= samples; ++i) CHECK(compensator.step(1.0).pressure_psi == Approx(20.0));
  return compensator;
}

}  // namespace

TEST_CASE("compensator by hand: an output at rest is averaged over two, three and up to eight samples") {
  const ElamModel model = taxel_of_one_line();
  TaxelCompensator compensator = still_at_one_volt(model, 0.01);
  // Each sample moves the mean from 1 V by its distance over the number of samples.
  double expected_v = 1.0;
  const double volts[] = {1.010, 1.008, 1.010, 1.012, 1.014, 1.016, 1.018, 1.020, 1.022};
  const double means[] = {1.005, 1.006, 1.007, 1.008, 1.009, 1.010, 1.011, 1.012125, 1.013359375};
  const int samples[] = {2, 3, 4, 5, 6, 7, 8, 8, 8};
  for (std::size_t i = 0; i < std::size(volts); ++i) {
    INFO(i);
    const Compensated result = compensator.step(volts[i]);
    expected_v += (volts[i] - expected_v) / samples[i];
    CHECK(expected_v == Approx(means[i]));
    CHECK(result.pressure_psi == Approx(20.0 * means[i]));
    // 10 mV of a sample over the root of their number.
    CHECK(result.uncertainty_psi == Approx(0.2 / std::sqrt(samples[i])));
  }
  // One sample earlier the output still counts as moving: it is taken as it comes.
  TaxelCompensator moving = still_at_one_volt(model, 0.01, 41);
  CHECK(moving.step(1.010).pressure_psi == Approx(20.2));
  CHECK(moving.step(1.010).uncertainty_psi == Approx(0.2 / std::sqrt(2.0)));
}

TEST_CASE("compensator by hand: five noises from the mean, of which the mean has its share, a new mean begins") {
  const ElamModel model = taxel_of_one_line();
  // Of one sample before: 5 x 10 mV x sqrt 2 = 70.7 mV.
  CHECK(still_at_one_volt(model, 0.01).step(1.0707).pressure_psi == Approx(20.707));  // half of it
  CHECK(still_at_one_volt(model, 0.01).step(1.0708).pressure_psi == Approx(21.416));
  // Of eight before: 50 mV x sqrt(9 / 8) = 53.03 mV; an eighth of 53 mV is 6.625 mV.
  const auto after_eight = [&](double volts) {
    TaxelCompensator compensator = still_at_one_volt(model, 0.01);
    for (int i = 0; i < 9; ++i) compensator.step(1.0);
    return compensator.step(volts).pressure_psi;
  };
  CHECK(after_eight(1.0530) == Approx(20.1325));
  CHECK(after_eight(1.0531) == Approx(21.062));
}

TEST_CASE("compensator by hand: steps of a moving output keep it moving, each counted up to its ceiling") {
  const ElamModel model = taxel_of_one_line();
  TaxelCompensator compensator = still_at_one_volt(model, 0.01);
  compensator.step(1.0);
  // A jump of 1 V counts 14: 2.34 x 23 / 24 becomes 2.15 + 14 / 24 = 2.74 and the next sample is taken as it comes.
  CHECK(compensator.step(2.0).pressure_psi == Approx(40.0));
  CHECK(compensator.step(2.01).pressure_psi == Approx(40.2));
}

TEST_CASE("compensator by hand: without noise each sample is taken, and nothing is uncertain, flat or unknown") {
  const ElamModel model = taxel_of_one_line();
  TaxelCompensator compensator(model, {});
  for (const double volts : {0.5, 0.5, 0.6, 0.59, 1.2}) {
    const Compensated result = compensator.step(volts);
    CHECK(result.pressure_psi == Approx(20.0 * volts));
    CHECK(result.uncertainty_psi == Approx(0.0).margin(1e-9));
    CHECK_FALSE((result.flat || result.unknown || result.out_of_range));
  }
}

TEST_CASE("compensator by hand: flat from 2 psi in four noises on, out of range from the dead band on") {
  const ElamModel model = taxel_of_one_line();
  // Four times 25 mV are 100 mV, which are 2 psi.
  CHECK_FALSE(TaxelCompensator(model, {.noise_v = 0.0249}).step(1.0).flat);
  CHECK(TaxelCompensator(model, {.noise_v = 0.0251}).step(1.0).flat);
  // 5.5 times 10 mV beyond the ends of the loop.
  for (const auto& [volts, out] : {std::pair{3.0549, false}, {3.0551, true}, {-0.0549, false}, {-0.0551, true}}) {
    INFO(volts);
    CHECK(TaxelCompensator(model, {.noise_v = 0.01}).step(volts).out_of_range == out);
  }
}

TEST_CASE("compensator by hand: a turn is remembered 5.5 noises behind the furthest output, either way") {
  const ElamModel model = taxel_of_one_line();
  const auto turned = [&](double back) {
    TaxelCompensator compensator(model, {.noise_v = 0.01});
    compensator.step(1.0);
    compensator.step(1.0 - back);
    return !compensator.ascending();
  };
  CHECK_FALSE(turned(0.0549));
  CHECK(turned(0.0551));
  const auto turned_again = [&](double up) {
    TaxelCompensator compensator(model, {.noise_v = 0.01});
    for (const double volts : {2.0, 1.0}) compensator.step(volts);
    CHECK_FALSE(compensator.ascending());
    compensator.step(1.0 + up);
    return compensator.ascending();
  };
  CHECK_FALSE(turned_again(0.0549));
  CHECK(turned_again(0.0551));
}

TEST_CASE("compensator by hand: behind the extreme the reading is on the way back, and half known") {
  const ElamModel model = bent_taxel();
  const double noise = 0.01;
  const ElamCurve up(model, true, 0.0, 0.0), down(model, false, 40.0, 2.0);
  const auto steepest = [&](const ElamCurve& curve, double at) {
    const double off = 4.0 * noise;
    return std::max(curve.input(at) - curve.input(at - off), curve.input(at + off) - curve.input(at)) / off;
  };
  TaxelCompensator compensator(model, {.noise_v = noise});
  compensator.step(2.0);  // 40 psi
  // 1.6 noises back it may stand still: the reading is that of the way up, its slope the larger of both.
  TaxelCompensator held = compensator;
  const Compensated still = held.step(2.0 - 0.0159);
  CHECK(still.pressure_psi == Approx(up.input(2.0 - 0.0159)));
  CHECK(still.uncertainty_psi == Approx(noise * std::max(steepest(up, 1.9841), steepest(down, 1.9841))));
  // Further back it is that of the way down; turned or not, the truth lies anywhere between: over the root of 12.
  const double y = 2.0 - 0.03, apart = std::abs(up.input(y) - down.input(y));
  REQUIRE(apart > 0.2);
  TaxelCompensator back = compensator;
  const Compensated doubtful = back.step(y);
  CHECK(doubtful.pressure_psi == Approx(down.input(y)));
  const double slope = std::max(steepest(up, y), steepest(down, y));
  CHECK(doubtful.uncertainty_psi == Approx(std::hypot(noise * slope, apart / std::sqrt(12.0))));
  // Beyond the dead band it has turned for certain.
  TaxelCompensator gone = compensator;
  const Compensated certain = gone.step(2.0 - 0.2);
  CHECK(certain.pressure_psi == Approx(down.input(1.8)));
  CHECK(certain.uncertainty_psi == Approx(noise * steepest(down, 1.8)));
}

TEST_CASE("compensator by hand: an unknown start goes up or down once its output is 5.5 noises away") {
  const ElamModel model = bent_taxel();
  const auto decided = [&](double away) {
    TaxelCompensator compensator(model, {.noise_v = 0.01});
    compensator.reset_unknown();
    compensator.step(1.5);
    compensator.step(1.5 + away);
    compensator.step(1.5 + away - std::copysign(0.054, away));  // not enough to turn again
    return compensator.ascending() ? 1 : -1;
  };
  CHECK(decided(0.0551) == 1);
  CHECK(decided(-0.0551) == -1);
  CHECK(decided(-0.0549) == 1);  // as at the start
}

TEST_CASE("an unknown start lies midway between the histories, with half their distance as its uncertainty, by hand") {
  const ElamModel model = bent_taxel();
  TaxelCompensator quiet(model, {});
  quiet.reset_unknown();
  const Compensated start = quiet.step(1.5);  // 30 psi if it rose, 22.5 psi if it fell from the top
  CHECK(start.unknown);
  CHECK(start.pressure_psi == Approx(26.25));
  CHECK(start.uncertainty_psi == Approx(3.75));
  // 10 mV of noise are 0.2 psi on the steeper of the two.
  TaxelCompensator noisy(model, {.noise_v = 0.01});
  noisy.reset_unknown();
  CHECK(noisy.step(1.5).uncertainty_psi == Approx(std::sqrt(3.75 * 3.75 + 0.2 * 0.2)));
  // Known from within half a psi on: at 90 mV 1.8 and 1.35 psi.
  quiet.reset_unknown();
  const Compensated known = quiet.step(0.09);
  CHECK_FALSE(known.unknown);
  CHECK(known.pressure_psi == Approx(1.8));
}

TEST_CASE("compensator's options by hand: zero is taken, less is refused, and a mean is of one sample at least") {
  const double least = std::numeric_limits<double>::denorm_min();
  for (double CompensatorOptions::*option :
       {&CompensatorOptions::noise_v, &CompensatorOptions::moving, &CompensatorOptions::jump_in_noises,
        &CompensatorOptions::lead_in_noises, &CompensatorOptions::band_in_noises, &CompensatorOptions::rest_in_noises,
        &CompensatorOptions::hold_in_noises, &CompensatorOptions::flat_in_noises, &CompensatorOptions::flat_psi,
        &CompensatorOptions::drift_share, &CompensatorOptions::known_psi}) {
    CompensatorOptions options;
    options.*option = 0.0;
    CHECK_NOTHROW(check_options(options));
    for (const double bad :
         {-least, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      options.*option = bad;
      CHECK_THROWS_AS(check_options(options), std::invalid_argument);
    }
  }
  CompensatorOptions options;
  options.longest_mean = 1;
  CHECK_NOTHROW(check_options(options));
  options.longest_mean = 0;
  CHECK_THROWS_WITH(check_options(options), Catch::Contains("longest_mean"));
}

TEST_CASE("compensator by hand: an advance of as much as the noise is held, and doubts its slope by the way back") {
  const ElamModel model = bent_taxel();
  // An advance from 1 V of 2 x 125 mV; up, 20 psi a volt.
  const auto uncertainty = [&](double advance) {
    TaxelCompensator compensator(model, {.noise_v = 0.125, .band_in_noises = 3.0, .hold_in_noises = 2.0});
    (void)compensator.step(1.0);
    return compensator.step(1.0 + advance).uncertainty_psi;
  };
  CHECK(uncertainty(0.25 + 1e-9) == Approx(2.5));
  CHECK(uncertainty(0.25) > 2.6);
  CHECK(uncertainty(0.25 - 1e-9) == Approx(uncertainty(0.25)));
}
