// The reference's error is one sum, by hand: that of a budget, of a verdict and of ReferenceUncertainty itself.
// Temperature in a budget, and budgets of a fitted array.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "analysis/error.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace straight_array;
using namespace tactbench;
using namespace uncertainty_example;

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
  CHECK_FALSE(temperature_effect_of(example.dataset, std::vector{warm}, example.fit, kStepC).assessed());
  Dataset calibration = at_temperature(example, 23.0, 0.0, 0.0), single = warm;
  for (Dataset* run : {&calibration, &single})
    for (SequenceData& data : run->sequences) data.repeats.resize(1);
  CHECK_FALSE(temperature_effect_of(calibration, std::vector{single}, example.fit, kStepC).assessed());
}

// Uncertainty of a reading: Student and Welch-Satterthwaite against published values, a budget recomputed by hand.

namespace {

std::string missing(const Uncertainty& uncertainty, UncertaintySource source) {
  return uncertainty.missing[static_cast<std::size_t>(source)];
}

}  // namespace

TEST_CASE("coverage factors: match JCGM 100, Table G.2") {
  const struct {
    double dof, k95, k95_45, k99;
  } table[] = {{1, 12.71, 13.97, 63.66}, {2, 4.30, 4.53, 9.92},  {3, 3.18, 3.31, 5.84},  {4, 2.78, 2.87, 4.60},
               {5, 2.57, 2.65, 4.03},    {6, 2.45, 2.52, 3.71},  {7, 2.36, 2.43, 3.50},  {8, 2.31, 2.37, 3.36},
               {9, 2.26, 2.32, 3.25},    {10, 2.23, 2.28, 3.17}, {16, 2.12, 2.17, 2.92}, {20, 2.09, 2.13, 2.85},
               {50, 2.01, 2.05, 2.68}};
  for (const auto& row : table) {
    CAPTURE(row.dof);
    CHECK(coverage_factor(row.dof, 0.95) == Approx(row.k95).margin(0.00501));
    CHECK(coverage_factor(row.dof, 0.9545) == Approx(row.k95_45).margin(0.00501));
    CHECK(coverage_factor(row.dof, 0.99) == Approx(row.k99).margin(0.00501));
  }
  CHECK(coverage_factor(100) == Approx(2.025).margin(0.0006));
  CHECK(coverage_factor(kInfiniteDof) == Approx(2.0).epsilon(1e-12));
  CHECK(coverage_factor(kInfiniteDof, 0.95) == Approx(1.959964).margin(1e-6));
  CHECK(coverage_factor(16.7, 0.99) == coverage_factor(16, 0.99));  // G.4.1: cut to a whole number
  CHECK_THROWS_AS(coverage_factor(0.5), std::invalid_argument);
  CHECK_THROWS_AS(coverage_factor(5, 1.0), std::invalid_argument);
}

TEST_CASE("coverage factors: u_c, effective degrees of freedom and U99 match the end gauge of JCGM 100, H.1") {
  // Table H.1 in nm: standard's certificate, measured difference, difference of expansion, of temperature.
  const std::vector<VarianceShare> shares = {{25, 18}, {9.7, 25.6}, {2.9, 50}, {16.6, 2}};
  const double combined = combined_uncertainty(shares);
  CHECK(combined == Approx(31.7).margin(0.05));  // "u_c(l) = 32 nm", u_c² = 1002 nm²
  CHECK(combined * combined == Approx(1002).margin(3));
  const double dof = effective_dof(shares);
  CHECK(dof == Approx(16.7).margin(0.1));
  CHECK(coverage_factor(dof, 0.99) * combined == Approx(93).margin(0.5));
}

TEST_CASE("budget: levels, readings, degrees of freedom and sums of a fitted array match hand-computed values") {
  const Example example;
  const Uncertainty uncertainty =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  REQUIRE(uncertainty.levels.size() == 61);  // the turn at 60 psi closes the way up
  const LevelUncertainty* level = uncertainty.level(30.0, false);
  REQUIRE(level != nullptr);
  const Budget& budget = level->worst;
  const auto taxel = static_cast<std::size_t>(budget.taxel);
  CHECK(budget.expanded_psi == level->expanded_psi[taxel]);
  std::vector<double> sorted = level->expanded_psi;
  std::ranges::sort(sorted);
  CHECK(budget.expanded_psi == sorted[2]);
  CHECK(level->median.expanded_psi == sorted[1]);
  // Of the sweeps from 60 to 0 psi one is in the first sequence and five in the second, each three times.
  CHECK(budget.readings == 3 * (1 + 5));

  const ElamModel& model = *elam_of(example.fit.taxels[taxel]);
  const ElamCurve falling(model, false, model.xu(), model.yu());
  const auto u_of = [&](UncertaintySource source) { return row_of(budget, source)->u_psi; };
  const double noise_v = example.dataset.noise_v[taxel], half_count = 0.5 * 7.62951094834821e-05;
  const double u_v = std::sqrt(noise_v * noise_v + half_count * half_count / 3.0 +
                               std::pow(row_of(budget, UncertaintySource::kZeroReturn)->width, 2));
  const double v = falling.output(30.0), slope = (falling.input(v + u_v) - falling.input(v - u_v)) / (2.0 * u_v);
  CHECK(u_of(UncertaintySource::kCertificate) == Approx(0.05));
  CHECK(u_of(UncertaintySource::kDrift) == Approx(0.05 / std::sqrt(3.0)));
  CHECK(u_of(UncertaintySource::kReferenceDigit) == Approx(0.5 * 100.0 / 32000.0 / std::sqrt(3.0)));
  CHECK(u_of(UncertaintySource::kNoise) == Approx(noise_v * slope));
  CHECK(u_of(UncertaintySource::kConverterStep) == Approx(half_count / std::sqrt(3.0) * slope));
  for (const auto& [source, dof] :
       {std::pair(UncertaintySource::kZeroReturn, 5.0), std::pair(UncertaintySource::kRepeatability, 12.0),
        std::pair(UncertaintySource::kConditioning, 5.0),
        std::pair(UncertaintySource::kNoise, 3.0 * (211 + 451))})  // frames x (scans - 1)
    CHECK(row_of(budget, source)->dof == dof);
  CHECK(row_of(budget, UncertaintySource::kUniformity) == nullptr);
  CHECK(budget.lower_psi() == Approx(budget.error_psi - budget.expanded_psi));
  CHECK(budget.upper_psi() == Approx(budget.error_psi + budget.expanded_psi));

  double variance = 0.0, fourth = 0.0;
  for (const Contribution& row : budget.contributions) {
    CHECK(row.u_psi == Approx(std::abs(row.sensitivity) * row.width / row.divisor));
    variance += row.u_psi * row.u_psi;
    if (std::isfinite(row.dof)) fourth += std::pow(row.u_psi, 4) / row.dof;
  }
  CHECK(budget.combined_psi == Approx(std::sqrt(variance)));
  CHECK(budget.dof == Approx(variance * variance / fourth));
  CHECK(budget.factor == coverage_factor(budget.dof));
  CHECK(budget.expanded_psi == Approx(budget.factor * std::sqrt(variance)));
}

TEST_CASE("budget: a source that cannot be assessed has no row, and a single sweep still has U") {
  Example example;
  const Uncertainty without = assess_uncertainty(example.dataset, example.fit, record_with_reference(""));
  CHECK_FALSE(missing(without, UncertaintySource::kCertificate).empty());
  CHECK(row_of(without.levels[0].median, UncertaintySource::kCertificate) == nullptr);
  for (SequenceData& data : example.dataset.sequences) data.repeats.resize(1);
  example.dataset.sequences.resize(1);  // one full sweep up, one down
  CHECK(assess_uncertainty(example.dataset, example.fit, {}).levels[3].median.expanded_psi > 0.0);
}

TEST_CASE("uncertainty: levels beyond the certificate have no U, and those within keep theirs") {
  const Example example;
  db::RunRecord run = record_with_reference(kWithCertificate);
  const Uncertainty whole = assess_uncertainty(example.dataset, example.fit, run);
  const auto with_range = [&](const char* range) {
    run = record_with_reference(std::string(kWithCertificate) + R"(,"certificate_range_psi":)" + range);
    run.highest_psi = 60.0;
    return assess_uncertainty(example.dataset, example.fit, run);
  };
  const Uncertainty found = with_range("[0,40]");
  CHECK(found.reference.beyond);
  CHECK(found.level(44.0, true) == nullptr);
  CHECK(found.level(60.0, true) == nullptr);
  for (const LevelUncertainty& level : found.levels)
    CHECK(level.worst.expanded_psi == whole.level(level.pressure_psi, level.up)->worst.expanded_psi);
  const Uncertainty none = with_range("[80,90]");
  CHECK(none.levels.empty());
}

TEST_CASE("uncertainty: taxels without a model have no U, and threads change nothing") {
  Example example;
  example.fit.taxels[1].status = TaxelStatus::kDead;
  const db::RunRecord run = record_with_reference(kWithCertificate);
  const Uncertainty one = assess_uncertainty(example.dataset, example.fit, run, {}, 1);
  const Uncertainty two = assess_uncertainty(example.dataset, example.fit, run, {}, 2);
  for (std::size_t i = 0; i < one.levels.size(); ++i) {
    CHECK(std::isnan(one.levels[i].expanded_psi[1]));
    CHECK(one.levels[i].expanded_psi[2] == two.levels[i].expanded_psi[2]);
    CHECK(one.levels[i].worst.taxel != 1);
  }
  CHECK(one.levels[one.chosen].pressure_psi == 30.0);
  CHECK_FALSE(one.levels[one.chosen].up);
  Dataset other = example.dataset;
  other.sensor_serial = "S2";
  CHECK_THROWS_AS(assess_uncertainty(other, example.fit, run), AnalysisError);
}

TEST_CASE("uncertainty: U of readings and judged values never falls when a due date passes") {
  const Example example;
  const Evaluation evaluation = evaluate(example.dataset, example.fit);
  // Runs of 2026-05-06. The due date moves back: in date, on its last day, a day past it, and further and further.
  std::vector<double> median_before, judged_before;
  double drift_before = 0.0;
  for (const char* due :
       {"", "2027-01-31", "2026-05-06", "2026-05-05", "2026-04-06", "2025-05-06", "2020-01-31", "1999-12-31"}) {
    INFO("due '" << due << "'");
    const db::RunRecord run = record_with_reference(kWithCertificate, due);
    const Uncertainty uncertainty = assess_uncertainty(example.dataset, example.fit, run);
    std::vector<double> median, judged;
    for (const LevelUncertainty& level : uncertainty.levels) {
      median.push_back(level.median.expanded_psi);
      CHECK(row_of(level.median, UncertaintySource::kDrift) != nullptr);
    }
    for (const Figure& figure :
         measured_figures(example.dataset, example.dataset, example.fit, evaluation, reference_uncertainty(run)))
      judged.push_back(figure.u.expanded);
    const double drift = row_of(uncertainty.levels.front().median, UncertaintySource::kDrift)->u_psi;
    CHECK(drift >= 0.05 / std::sqrt(3.0) * (1.0 - 1e-12));
    CHECK(drift >= drift_before);
    drift_before = drift;
    for (std::size_t i = 0; i < median_before.size(); ++i) CHECK(median[i] >= median_before[i]);
    for (std::size_t i = 0; i < judged_before.size(); ++i) CHECK(judged[i] >= judged_before[i]);
    median_before = median;
    judged_before = judged;
    CHECK(missing(uncertainty, UncertaintySource::kDrift).empty());
  }
  CHECK(drift_before > 10.0 * 0.05 / std::sqrt(3.0));  // 26 years past a limit for one
}

TEST_CASE("conditions of use: a condition that was not measured has no valid U") {
  const Example example;
  const Uncertainty alone = assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  REQUIRE(alone.conditions.size() == kUseConditions);
  for (std::size_t which = 0; which < kUseConditions; ++which) {
    const ConditionUncertainty& own = alone.condition(static_cast<UseCondition>(which));
    CHECK((!own.valid() && own.histories == 0 && own.expanded_psi.empty() && !own.name.empty()));
  }
  CHECK_FALSE(alone.worst().has_value());

  // The calibration's sequences again: its full sweeps tell, its inner branches are the fitted ones.
  const synthetic::Array array({.rows = 1, .columns = 3, .sensor_seed = 4});
  const Dataset again = synthetic::run(array, {.seed = 11, .noise_v = 0.0015, .repeats = 2});
  UncertaintyInputs inputs;
  inputs.history.same = {&again};
  const Uncertainty with =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate), inputs);
  const ConditionUncertainty& sweeps = with.condition(UseCondition::kFullSweeps);
  REQUIRE(sweeps.valid());
  CHECK(with.worst() == UseCondition::kFullSweeps);
  CHECK_FALSE(with.condition(UseCondition::kReversals).valid());
  CHECK_FALSE(with.condition(UseCondition::kLater).valid());
  const ReadingUncertainty at = reading_uncertainty(sweeps, 1, 31.0, true);
  const ReadingUncertainty low = reading_uncertainty(sweeps, 1, 30.0, true);
  const ReadingUncertainty high = reading_uncertainty(sweeps, 1, 32.0, true);
  CHECK(at.expanded_psi == Approx(0.5 * (low.expanded_psi + high.expanded_psi)));
  CHECK(at.error_psi == Approx(0.5 * (low.error_psi + high.error_psi)));
  const std::string in_part = std::string(kWithCertificate) + R"(,"certificate_range_psi":[0,40])";
  const Uncertainty part = assess_uncertainty(example.dataset, example.fit, record_with_reference(in_part), inputs);
  const ConditionUncertainty& cut = part.condition(UseCondition::kFullSweeps);
  CHECK(std::isfinite(reading_uncertainty(cut, 1, 38.0, true).expanded_psi));
  CHECK(std::isnan(reading_uncertainty(cut, 1, 50.0, true).expanded_psi));
  // Without a certificate U of the reference is not known, and so none.
  CHECK_FALSE(
      assess_uncertainty(example.dataset, example.fit, {}, inputs).condition(UseCondition::kFullSweeps).valid());
}
