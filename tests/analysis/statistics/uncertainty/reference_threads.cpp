// The reference's own error is one sum, by hand: that of a budget, of a verdict and of ReferenceUncertainty itself.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/error.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/effect_runs.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;

namespace {

ReferenceUncertainty whole_chain() {
  ReferenceUncertainty reference;
  reference.reading_psi = {0.0, 60.0};
  reference.expanded_psi = {0.04, 0.16};  // 0.12 at 40 psi
  reference.drift_stated_psi = reference.drift_psi = 0.05;
  reference.resolution_psi = 0.02;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    reference.limits[part].half_width_psi = 0.1 * (1.0 + static_cast<double>(part));  // 0.1, 0.2, 0.3, 0.4
  return reference;
}

// Certificate's U / 2; then the squares of half-widths of rectangles.
double by_hand_psi(double certificate_psi, double rectangles) {
  return std::sqrt(certificate_psi * certificate_psi / 4.0 + rectangles / 3.0);
}

double of_reference(const ReferenceUncertainty& reference) {
  const Dataset dataset = known_loop();
  const SensorModel fit = straight_fit();
  const SweepErrors errors = sweep_errors(dataset, fit);
  const UncertaintyInputs none;
  const Budget budget = BudgetMaker(dataset, fit, errors, reference, 0.0, none, 1).budget(0, 2);
  REQUIRE(budget.pressure_psi == 40.0);
  double squares = 0.0;
  for (const Contribution& row : budget.contributions)
    if (row.source <= UncertaintySource::kReferenceTemperature)  // they come first
      squares += row.u_psi * row.u_psi;
  return std::sqrt(squares);
}

double of_verdict(const ReferenceUncertainty& reference) {
  const auto combined = [](const ReferenceUncertainty& of) {
    const Dataset dataset = known_loop();
    const auto all = measured_figures(dataset, dataset, straight_fit(), evaluate(dataset, straight_fit()), of);
    REQUIRE(all.front().criterion == Criterion::kMeanError);
    return all.front().u.combined;
  };
  ReferenceUncertainty none;
  none.drift_missing = none.resolution_missing = "none";
  return std::sqrt(std::pow(combined(reference), 2) - std::pow(combined(none), 2));
}

}  // namespace

TEST_CASE("reference error: budget and verdict sum the same parts, the verdict with the certificate's largest U") {
  ReferenceUncertainty reference = whole_chain();
  const auto check_sums = [&](double rectangles) {
    CHECK(reference.combined_u(40.0) == Approx(by_hand_psi(0.12, rectangles)));
    CHECK(of_reference(reference) == Approx(by_hand_psi(0.12, rectangles)));
    CHECK(of_verdict(reference) == Approx(by_hand_psi(0.16, rectangles)).epsilon(1e-6));
  };
  check_sums(0.05 * 0.05 + 0.01 * 0.01 + 0.01 + 0.04 + 0.09 + 0.16);  // drift, half a digit, the four limits
  // What is not stated is in none of the sums.
  reference.drift_missing = reference.resolution_missing = "not stated";
  reference.limits[1].half_width_psi = 0.0;
  check_sums(0.01 + 0.09 + 0.16);
}

// Temperature in the budget: coefficients by hand from runs made by formula, and what keeps them from being assessed.

using namespace tactbench::analysis;
using namespace effect_runs;

namespace {

constexpr double kStepC = 0.1;

TemperatureEffect temperature_effect_in(const Example& example, const std::vector<Dataset>& others) {
  return temperature_effect_of(at_temperature(example, 23.0, 0.0, 0.0), others, example.fit, kStepC);
}

}  // namespace

TEST_CASE("temperature effect: changes, coefficients and their uncertainties match hand-computed values") {
  // 0.5 V at 0 psi, 0.1 V a psi. At 28 degC the taxels' zeros are 0.4 and 0.2 V higher, their gains 3 and 1 % (2 and 0
  // % and 4 and 2 % in the two repeats; the zeros 20 mV less and more).
  const auto loops = [](double celsius, double warm,
                        const std::vector<double>& levels = {0, 10, 20, 30, 40, 30, 20, 10, 0}) {
    SequenceData sequence{"loop", {}};
    for (const double r : {-1.0, 1.0}) {
      Repeat repeat;
      for (const double psi : levels) {
        repeat.steps.push_back({psi, psi});
        for (const auto& [zero, share] : {std::pair{0.4, 0.03}, std::pair{0.2, 0.01}})
          repeat.volts.push_back(0.5 + 0.1 * psi + warm * (zero + 0.02 * r + (share + 0.01 * r) * 0.1 * psi));
      }
      sequence.repeats.push_back(repeat);
    }
    Dataset dataset;
    dataset.rows = 1;
    dataset.columns = 2;
    dataset.temperatures_c = {celsius - 0.1, celsius + 0.1};
    dataset.sequences = {sequence};
    return dataset;
  };
  SensorModel fit;
  fit.rows = 1;
  fit.columns = 2;
  fit.taxels.resize(2);
  for (ModelTaxel& taxel : fit.taxels) taxel.status = TaxelStatus::kFitted;
  const TemperatureEffect effect =
      temperature_effect_of(loops(23.0, 0.0), std::vector<Dataset>{loops(28.0, 1.0)}, fit, kStepC);
  REQUIRE(effect.assessed());
  REQUIRE(effect.change.size() == 2);
  CHECK(effect.temperature_c[0] == Approx(23.0));
  CHECK(effect.temperature_c[1] == Approx(28.0));
  CHECK(effect.change[0].share == Approx(0.0).margin(1e-12));
  CHECK(effect.change[0].zero_v == Approx(0.0).margin(1e-12));
  CHECK(effect.change[1].share == Approx(0.02));
  CHECK(effect.change[1].zero_v == Approx(0.3));
  CHECK(effect.per_kelvin.share == Approx(0.004));
  CHECK(effect.per_kelvin.zero_v == Approx(0.06));
  CHECK_THAT(effect.display_text(), Catch::Contains("+0.4000") && Catch::Contains("+60.000"));  // %, mV
  // The taxels' own slopes: 0.6 and 0.2 % a kelvin, 80 and 40 mV a kelvin.
  CHECK(effect.deviation.share == Approx(0.004 / std::sqrt(2.0)));
  CHECK(effect.deviation.zero_v == Approx(0.04 / std::sqrt(2.0)));
  // Squares within the repeats 2 x 0.01^2 with two degrees of freedom: s = 1 %, of the difference of two means of two
  // again 1 %, over 5 K. Alike for 20 mV.
  CHECK(effect.from_repeats);
  CHECK(effect.dof == 2.0);
  CHECK(effect.u.share == Approx(0.01 / 5));
  CHECK(effect.u.zero_v == Approx(0.02 / 5));
  CHECK(effect.low_c == Approx(22.9));
  CHECK(effect.high_c == Approx(23.1));
  CHECK(effect.resolution_c == kStepC);
  CHECK(effect.half_width_c() == Approx(0.15));
  // 2 V over the zero: 60 + 8 mV a kelvin, beside 4 and 4 mV of u and 28.3 and 5.66 mV between taxels.
  const double volts_a_kelvin = 1e-3 * std::sqrt(68.0 * 68.0 + 16.0 + 16.0 + 800.0 + 32.0);
  CHECK(effect.width_v(2.0) == Approx(0.15 * volts_a_kelvin));
  // A thermometer that is itself known to u = 0.2 K: a rectangle of that variance is sqrt(3) 0.2 K to each side.
  const TemperatureEffect wider =
      temperature_effect_of(loops(23.0, 0.0), std::vector<Dataset>{loops(28.0, 1.0)}, fit, kStepC, 0.2);
  CHECK(wider.half_width_c() == Approx(std::sqrt(0.15 * 0.15 + 3.0 * 0.04)));  // 0.377 K
  CHECK(wider.width_v(2.0) == Approx(std::sqrt(0.15 * 0.15 + 0.12) * volts_a_kelvin));
  // Five levels are needed, of each run.
  const std::vector<double> four{0, 10, 20, 40, 20, 10, 0};
  CHECK_FALSE(temperature_effect_of(loops(23.0, 0.0, four), std::vector<Dataset>{loops(28.0, 1.0)}, fit, kStepC)
                  .not_assessed.empty());
  CHECK_FALSE(temperature_effect_of(loops(23.0, 0.0), std::vector<Dataset>{loops(28.0, 1.0, four)}, fit, kStepC)
                  .not_assessed.empty());
}

TEST_CASE("temperature effect: three runs off a line give the coefficient's uncertainty, with one degree of freedom") {
  const Example example(0.0);
  // Off by e, -2 e, e: residual standard deviation sqrt(6) e, over the root of the temperatures' squares about their
  // mean.
  constexpr double kOff = 0.003;
  const TemperatureEffect bent = temperature_effect_in(
      example, {at_temperature(example, 28.0, -0.01 - 3.0 * kOff, 0.0), at_temperature(example, 33.0, -0.02, 0.0)});
  CHECK_FALSE(bent.from_repeats);
  CHECK(bent.dof == 1.0);
  CHECK(bent.per_kelvin.share == Approx(-0.002).epsilon(0.01));
  CHECK(bent.u.share == Approx(std::sqrt(6.0) * kOff / std::sqrt(50.0)).epsilon(0.02));
}

TEST_CASE("temperature effect: needs the same sensor, two temperatures, readings, full loops and two repeats") {
  const Example example;
  const Dataset warm = at_temperature(example, 28.0, -0.01, 0.0);
  Dataset other = warm, silent = warm, held = hold_run(example, {});
  other.sensor_serial = "S2";
  CHECK_THROWS_AS(temperature_effect_in(example, {other}), AnalysisError);
  silent.temperatures_c.clear();
  held.temperatures_c = {28.0};  // no loop to compare with
  for (const std::vector<Dataset>& runs : {std::vector<Dataset>{}, std::vector{silent}, std::vector{held}}) {
    const TemperatureEffect effect = temperature_effect_in(example, runs);
    CHECK_FALSE(effect.assessed());
    CHECK_FALSE(effect.not_assessed.empty());
    CHECK(effect.display_text().empty());
  }
  CHECK_FALSE(at_another_temperature(example.dataset.temperatures_c, silent.temperatures_c));
  CHECK_FALSE(temperature_effect_of(example.dataset, std::vector{warm}, example.fit, kStepC).assessed());
  Dataset calibration = at_temperature(example, 23.0, 0.0, 0.0), single = warm;
  for (Dataset* run : {&calibration, &single})
    for (SequenceData& data : run->sequences) data.repeats.resize(1);
  CHECK_FALSE(temperature_effect_of(calibration, std::vector{single}, example.fit, kStepC).assessed());
}
