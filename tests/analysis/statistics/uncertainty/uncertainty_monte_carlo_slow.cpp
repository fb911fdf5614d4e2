// Eq. (10) and the sensitivities of a budget against a Monte Carlo propagation of the same inputs (JCGM 101) through
// the compensator. It tells whether the propagation is right, not whether the inputs are: that U holds the truth is
// tested on the plant's pressure (tests/bench/reporting/coverage_long.cpp).
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/compensate/curves.h"
#include "analysis/compensate/turning.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace effect_runs;

namespace {

// JCGM 101, 5: draws of all inputs, pushed through the taxel's compensation along a whole loop. Half of the interval
// between the quantiles that leave 2.275 % out on either side, at each level: up, then down.
std::vector<double> monte_carlo(const Example& example, const Uncertainty& uncertainty, std::size_t taxel, int trials) {
  const ModelTaxel& fit = example.fit.taxels[taxel];
  const ElamModel& model = *elam_of(fit);
  const ElamCurve up(model, true, model.x0(), model.y0()), down(model, false, model.xu(), model.yu());
  const std::size_t levels = uncertainty.levels.size();
  std::vector<std::vector<double>> errors(levels);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  const auto rising = static_cast<std::size_t>(std::ranges::count_if(uncertainty.levels, &LevelUncertainty::up));
  std::vector<const Budget*> budgets(levels);
  for (std::size_t i = 0; i < levels; ++i) budgets[i] = &uncertainty.levels[i].median;
  const auto width_of = [&](std::size_t i, UncertaintySource source) { return row_of(*budgets[i], source)->width; };
  // Absent from a budget: not assessed, no width.
  const auto width_if = [&](std::size_t i, UncertaintySource source) {
    const Contribution* row = row_of(*budgets[i], source);
    return row == nullptr ? 0.0 : row->width;
  };
  const bool has_warmth = row_of(*budgets[0], UncertaintySource::kTemperature) != nullptr;
  const double step = 2.0 * width_of(0, UncertaintySource::kConverterStep);
  CompensatorSetup setup;
  setup.zero = model.y0();
  setup.noise = fit.noise;
  for (int trial = 0; trial < trials; ++trial) {
    TurningCompensator<ElamStack> compensator(ElamStack(model), setup);
    const double certificate = normal(random), drift = even(random), digit = even(random), zero = normal(random);
    const double warmth = has_warmth ? even(random) : 0.0;  // the day is warm at every level
    for (std::size_t k = 0; k < levels; ++k) {
      const std::size_t i = k < rising ? k : rising + levels - 1 - k;  // up, then from the top down
      const double level = budgets[i]->pressure_psi;
      const double clean = (budgets[i]->up ? up : down).output(level);
      const double volts = clean + zero * width_of(i, UncertaintySource::kZeroReturn) +
                           warmth * width_if(i, UncertaintySource::kTemperature) + fit.noise * normal(random);
      // The one reading that is late has crept; the way there has not.
      const double creep_v = width_if(i, UncertaintySource::kCreep);
      const double creep = creep_v > 0.0 ? even(random) * creep_v : 0.0;
      auto late = compensator;
      const double estimate = late.step(step * std::round((volts + creep) / step), 0.0).pressure_psi;
      (void)compensator.step(step * std::round(volts / step), 0.0);
      // What readings tell enters the result itself.
      double readings = 0.0;
      for (const Contribution& row : budgets[i]->contributions)
        if (std::string(text_of(row.source).unit) == "psi" && text_of(row.source).type == 'A')
          readings += row.u_psi * normal(random);
      const double reference = certificate * row_of(*budgets[i], UncertaintySource::kCertificate)->u_psi +
                               drift * width_of(i, UncertaintySource::kDrift) +
                               digit * width_of(i, UncertaintySource::kReferenceDigit);
      errors[i].push_back(estimate - level + readings - reference);
    }
  }
  std::vector<double> half;
  for (std::vector<double>& values : errors) {
    std::ranges::sort(values);
    const auto at = [&](double share) { return values[static_cast<std::size_t>(share * (trials - 1))]; };
    half.push_back(0.5 * (at(0.5 + 0.5 * kCoverageProbability) - at(0.5 - 0.5 * kCoverageProbability)));
  }
  return half;
}

struct Agreement {
  int linear = 0, off = 0;  // levels: within bounds, required; not linear and 10 % off
};
// `above`: by how much U may exceed the interval.
Agreement agreement(const Uncertainty& uncertainty, const std::vector<double>& half, double above = 0.10) {
  Agreement found;
  for (std::size_t i = 0; i < half.size(); ++i) {
    const Budget& budget = uncertainty.levels[i].median;
    const double ratio = coverage_factor(kInfiniteDof) * budget.combined_psi / half[i];
    CAPTURE(budget.pressure_psi, budget.up, budget.expanded_psi, half[i], ratio);
    if (budget.linear) {
      ++found.linear;
      CHECK(ratio >= 0.87);
      CHECK(ratio <= 1.0 + above);
    } else if (std::abs(ratio - 1.0) > 0.10) {
      ++found.off;
    }
  }
  return found;
}

}  // namespace

TEST_CASE("U of a reading: agrees with Monte Carlo if the inverse is linear, and is marked if it is not") {
  // The falling curve of this taxel is nearly flat at the top, as the paper's is.
  Example example(0.006, 1);
  const Uncertainty uncertainty =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  const std::vector<double> half = monte_carlo(example, uncertainty, 0, 48000);
  const auto [linear, off] = agreement(uncertainty, half);
  CHECK(linear >= 40);
  CHECK(off >= 2);
}

TEST_CASE("U of a reading: agrees with Monte Carlo with creep and temperature included") {
  const Example example(0.006, 1);
  UncertaintyInputs inputs;
  inputs.creep = creep_effect_of(read_after(example.dataset, 2.0),
                                 std::vector<Dataset>{hold_run(example, {.per_decade = 0.006})}, example.fit);
  Dataset calibration = at_temperature(example, 23.0, 0.0, 0.0);
  calibration.temperatures_c = {21.0, 25.0};
  inputs.temperature = temperature_effect_of(
      calibration, std::vector<Dataset>{at_temperature(example, 30.0, -0.014, 0.0)}, example.fit, 0.1);
  REQUIRE(inputs.creep.assessed());
  REQUIRE(inputs.temperature.assessed());
  const Uncertainty uncertainty =
      assess_uncertainty(calibration, example.fit, record_with_reference(kWithCertificate), inputs);
  const Uncertainty without = assess_uncertainty(calibration, example.fit, record_with_reference(kWithCertificate));
  // They matter at mid range; unloading, the compensator takes a gain that is common to the loop off by itself.
  const Budget& budget = uncertainty.level(30.0, true)->median;
  for (const UncertaintySource source : {UncertaintySource::kCreep, UncertaintySource::kTemperature})
    CHECK(row_of(budget, source)->u_psi > 0.15 * budget.combined_psi);
  CHECK(budget.combined_psi > without.level(30.0, true)->median.combined_psi);
  // 95.45 % of a rectangle lie within 1.65 of its standard deviations: where rectangles dominate k = 2 is too much.
  CHECK(agreement(uncertainty, monte_carlo(example, uncertainty, 0, 48000), 0.15).linear >= 30);
}
