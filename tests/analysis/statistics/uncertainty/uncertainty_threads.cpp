// Uncertainty of a reading: Student and Welch-Satterthwaite against published values, a budget recomputed by hand.
#include "analysis/statistics/uncertainty/uncertainty.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "analysis/compensate/compensator.h"
#include "analysis/identify/taxel_stream.h"
#include "analysis/statistics/conformity/verdict.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace uncertainty_example;

namespace {

std::string missing(const Uncertainty& uncertainty, UncertaintySource source) {
  return uncertainty.missing[static_cast<std::size_t>(source)];
}

}  // namespace

TEST_CASE("Student's factors are those of JCGM 100, Table G.2") {
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

TEST_CASE("the end gauge of JCGM 100, H.1: u_c, effective degrees of freedom, U99") {
  // Table H.1 in nm: standard's certificate, measured difference, difference of expansion, of temperature.
  const std::vector<VarianceShare> shares = {{25, 18}, {9.7, 25.6}, {2.9, 50}, {16.6, 2}};
  const double combined = combined_uncertainty(shares);
  CHECK(combined == Approx(31.7).margin(0.05));  // "u_c(l) = 32 nm", u_c² = 1002 nm²
  CHECK(combined * combined == Approx(1002).margin(3));
  const double dof = effective_dof(shares);
  CHECK(dof == Approx(16.7).margin(0.1));
  CHECK(coverage_factor(dof, 0.99) * combined == Approx(93).margin(0.5));
  CHECK(std::isinf(effective_dof(std::vector<VarianceShare>{{1.0}, {2.0}})));
  CHECK(effective_dof(std::vector<VarianceShare>{{3.0, 7.0}}) == Approx(7.0));
}

TEST_CASE("a budget is what its readings, voltages and certificate give by hand") {
  const Example example;
  const Uncertainty uncertainty =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  REQUIRE(uncertainty.levels.size() == 61);  // the turn at 60 psi closes the way up
  const LevelUncertainty* level = uncertainty.level(30.0, false);
  REQUIRE(level != nullptr);
  const Budget& budget = level->worst;
  const auto taxel = static_cast<std::size_t>(budget.taxel);
  CHECK(budget.expanded_psi == level->expanded_psi[taxel]);
  CHECK(budget.expanded_psi == *std::ranges::max_element(level->expanded_psi));
  std::vector<double> sorted = level->expanded_psi;
  std::ranges::sort(sorted);
  CHECK(level->median.expanded_psi == sorted[1]);

  // Every frame through the compensator; readings at 30 psi of the sweeps from 60 to 0 psi, by the place of the sweep
  // in its sequence: these have the same way behind them.
  std::map<std::pair<std::string, std::size_t>, std::vector<double>> groups;
  std::vector<double> readings, returns;
  TaxelStream compensator(example.fit.taxels[taxel]);
  for (const SequenceData& data : example.dataset.sequences) {
    for (const Repeat& repeat : data.repeats) {
      const std::size_t steps = repeat.steps.size();
      std::vector<double> estimates;
      for (std::size_t i = 0; i < steps; ++i)
        estimates.push_back(compensator.step(repeat.volts[i * 3 + taxel]).pressure_psi);
      returns.push_back(repeat.volts[(steps - 1) * 3 + taxel] - repeat.volts[taxel]);
      for (std::size_t top = 0; top + 30 < steps; ++top) {
        if (repeat.steps[top].setpoint_psi != 60.0 || repeat.steps[top + 30].setpoint_psi != 0.0) continue;
        readings.push_back(estimates[top + 15] - repeat.steps[top + 15].reference_psi);
        groups[{data.name, top}].push_back(readings.back());
      }
    }
  }
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  REQUIRE(readings.size() == 3 * (1 + 5));
  REQUIRE(groups.size() == 6);
  CHECK(budget.readings == readings.size());
  CHECK(budget.error_psi == Approx(mean(readings)));
  // H.5.2: mean squares within and between groups of three.
  double within = 0.0, between = 0.0;
  for (const auto& [place, own] : groups) {
    for (const double error : own) within += std::pow(error - mean(own), 2) / (18.0 - 6.0);
    between += 3.0 * std::pow(mean(own) - mean(readings), 2) / 5.0;
  }
  const double s_between = std::sqrt(std::max(0.0, (between - within) / 3.0));

  const ElamModel& model = *elam_of(example.fit.taxels[taxel]);
  const ElamCurve falling(model, false, model.xu(), model.yu());
  const double noise_v = example.dataset.noise_v[taxel], half_count = 0.5 * 7.62951094834821e-05;
  // Six returns, each with the noise of two frames.
  double scatter_v = 0.0;
  for (const double off : returns) scatter_v += std::pow(off - mean(returns), 2) / 5.0;
  REQUIRE(returns.size() == 6);
  const double zero_v = std::sqrt(std::max(0.0, std::pow(mean(returns), 2) - noise_v * noise_v / 3.0) / 3.0 +
                                  std::max(0.0, scatter_v - 2.0 * noise_v * noise_v) / 6.0);
  const double u_v = std::sqrt(noise_v * noise_v + half_count * half_count / 3.0 + zero_v * zero_v);
  const double v = falling.output(30.0), slope = (falling.input(v + u_v) - falling.input(v - u_v)) / (2.0 * u_v);

  const auto u_of = [&](UncertaintySource source) { return row_of(budget, source)->u_psi; };
  CHECK(u_of(UncertaintySource::kCertificate) == Approx(0.05));
  CHECK(u_of(UncertaintySource::kDrift) == Approx(0.05 / std::sqrt(3.0)));
  CHECK(u_of(UncertaintySource::kReferenceDigit) == Approx(0.5 * 100.0 / 32000.0 / std::sqrt(3.0)));
  CHECK(u_of(UncertaintySource::kNoise) == Approx(noise_v * slope));
  CHECK(u_of(UncertaintySource::kConverterStep) == Approx(half_count / std::sqrt(3.0) * slope));
  CHECK(u_of(UncertaintySource::kZeroReturn) == Approx(zero_v * slope).margin(1e-12));
  CHECK(row_of(budget, UncertaintySource::kZeroReturn)->dof == 5);
  const double noise2 = std::pow(noise_v * slope, 2);
  CHECK(u_of(UncertaintySource::kRepeatability) == Approx(std::sqrt(std::max(0.0, within - noise2))).margin(1e-12));
  CHECK(row_of(budget, UncertaintySource::kRepeatability)->dof == 12);
  CHECK(u_of(UncertaintySource::kConditioning) == Approx(s_between).margin(1e-12));
  CHECK(row_of(budget, UncertaintySource::kConditioning)->dof == 5);
  CHECK(u_of(UncertaintySource::kModel) ==
        Approx(std::sqrt(std::max(within, noise2) / 18.0 + s_between * s_between / 6.0)));
  CHECK(row_of(budget, UncertaintySource::kNoise)->dof == 3 * (211 + 451));  // frames x (scans - 1)
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

TEST_CASE("contributions that cannot be assessed state the reason, those from other runs are included") {
  Example example;
  const Uncertainty without = assess_uncertainty(example.dataset, example.fit, record_with_reference(""));
  CHECK_THAT(missing(without, UncertaintySource::kUniformity), Catch::Contains("0, 90, 180 and 270"));
  CHECK_THAT(missing(without, UncertaintySource::kMounting), Catch::Contains("mounted anew"));
  CHECK_THAT(missing(without, UncertaintySource::kCreep), Catch::Contains("creep-hold"));
  CHECK_THAT(missing(without, UncertaintySource::kTemperature), Catch::Contains("no temperature readings"));
  CHECK_FALSE(missing(without, UncertaintySource::kCertificate).empty());
  CHECK(missing(without, UncertaintySource::kNoise).empty());
  CHECK(row_of(without.levels[0].median, UncertaintySource::kCertificate) == nullptr);

  UncertaintyInputs inputs;
  inputs.uniformity = GivenUncertainty{0.03, 0.004, 3.0, "runs 2 to 5"};
  const Uncertainty with = assess_uncertainty(example.dataset, example.fit, record_with_reference(""), inputs);
  const Budget &before = without.level(40.0, true)->median, &after = with.level(40.0, true)->median;
  REQUIRE(row_of(after, UncertaintySource::kUniformity) != nullptr);
  CHECK(row_of(after, UncertaintySource::kUniformity)->u_psi == Approx(std::hypot(0.03, 0.16)));
  CHECK(row_of(after, UncertaintySource::kUniformity)->dof == 3.0);
  CHECK(after.combined_psi > before.combined_psi);
  CHECK(with.from[static_cast<std::size_t>(UncertaintySource::kUniformity)] == "runs 2 to 5");

  example.dataset.temperatures_c = {23.0};
  example.dataset.scans = 1;
  for (SequenceData& data : example.dataset.sequences) data.repeats.resize(1);
  example.dataset.sequences.resize(1);  // one full sweep up, one down
  const Uncertainty one = assess_uncertainty(example.dataset, example.fit, {});
  CHECK_THAT(missing(one, UncertaintySource::kRepeatability), Catch::Contains("more repeats"));
  CHECK_THAT(missing(one, UncertaintySource::kNoise), Catch::Contains("one scan"));
  CHECK_THAT(missing(one, UncertaintySource::kTemperature), Catch::Contains("another temperature"));
  CHECK_THAT(missing(one, UncertaintySource::kConverterStep), Catch::Contains("volts a count"));
  CHECK(one.levels[3].median.expanded_psi > 0.0);
}

TEST_CASE("taxels without a model have no uncertainty, and threads change nothing") {
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

TEST_CASE("U of readings and judged figures never falls when a due date passes") {
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
    for (const JudgedUncertainty& figure :
         judged_uncertainties(example.dataset, example.dataset, example.fit, evaluation, reference_uncertainty(run)))
      judged.push_back(figure.expanded);
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
