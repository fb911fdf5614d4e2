// Creep in the budget: shares by hand from outputs by formula, and what keeps them from being assessed.
#include "analysis/statistics/figures/creep_effect.h"

#include <catch2/catch.hpp>

#include "analysis/error.h"
#include "tests/analysis/support/effect_runs.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace effect_runs;

namespace {

// Mean of log10(t) over the last five frames of a hold that ends at `end_s`, 2 s apart.
double end_decades(double end_s) {
  double sum = 0.0;
  for (int i = 0; i < 5; ++i) sum += std::log10(end_s - 2.0 * i) / 5.0;
  return sum;
}

CreepEffect creep_effect_in(const Example& example, const std::vector<Dataset>& runs, double read_after_s = 2.0) {
  return creep_effect_of(read_after(example.dataset, read_after_s), runs, example.fit);
}

}  // namespace

TEST_CASE("creep is the change of the output from the calibration's time to the end of the hold, by hand") {
  const Example example;
  const CreepEffect effect = creep_effect_in(example, {hold_run(example, {})});
  REQUIRE(effect.assessed());
  REQUIRE(effect.levels.size() == 1);
  CHECK(effect.read_after_s == 2.0);
  CHECK(effect.to_s == Approx(200.0));
  CHECK_FALSE(effect.extrapolated_back);
  CHECK(effect.levels[0].up);
  // 1 % a decade of the output at 1 s, over the output at 2 s.
  const double expected = 0.01 * (end_decades(200.0) - std::log10(2.0)) / (1.0 + 0.01 * std::log10(2.0));
  for (std::size_t taxel = 0; taxel < 3; ++taxel) {
    CHECK(effect.levels[0].share[taxel] == Approx(expected).epsilon(1e-9));
    for (const double pressure : {4.0, 40.0, 60.0}) CHECK(effect.share(taxel, pressure, false) == Approx(expected));
  }
  CHECK(effect.levels[0].median_share == Approx(expected));
  CHECK_THAT(effect.in_words(), Catch::Contains("creep-hold (40.0 psi loading for 200 s: 1.9") &&
                                    Catch::Contains("from 2.0 s") && Catch::Contains("to 200 s") &&
                                    Catch::Contains("so does the other branch"));
}

TEST_CASE("a reading between two frames, a moving reference and a hold that begins late are allowed for") {
  const Example example;
  const double first = 0.01 * 0.5 * (std::log10(2.0) + std::log10(4.0));
  CHECK(creep_effect_in(example, {hold_run(example, {})}, 3.0).share(0, 40.0, true) ==
        Approx((0.01 * end_decades(200.0) - first) / (1.0 + first)).epsilon(1e-9));
  // The regulator creeps by 0.2 psi: the model's slope takes off what that pushes.
  const double still = creep_effect_in(example, {hold_run(example, {})}).share(1, 40.0, true);
  HoldOptions pushed;
  pushed.reference_drift_psi = 0.2;
  CHECK(creep_effect_in(example, {hold_run(example, pushed)}).share(1, 40.0, true) == Approx(still).epsilon(0.03));
  HoldOptions late;
  late.from_s = 20.0;
  late.frames = 91;  // to 200 s
  const CreepEffect carried = creep_effect_in(example, {hold_run(example, late)});
  CHECK(carried.extrapolated_back);
  const double seen = 0.01 * (end_decades(200.0) - std::log10(20.0)) / (1.0 + 0.01 * std::log10(20.0));
  CHECK(carried.share(2, 40.0, true) == Approx(2.0 * seen).epsilon(1e-9));  // two decades, one of them seen
  CHECK_THAT(carried.in_words(), Catch::Contains("extended on the logarithm of time"));
}

TEST_CASE("levels between held ones are interpolated, and of two holds of a level the larger share counts") {
  const Example example;
  HoldOptions low, high, weak;
  low.level_psi = 20.0;
  high.per_decade = 0.02;
  weak.per_decade = 0.005;
  const CreepEffect effect =
      creep_effect_in(example, {hold_run(example, high), hold_run(example, low), hold_run(example, weak)});
  REQUIRE(effect.levels.size() == 2);
  const double at_20 = effect.share(0, 20.0, true), at_40 = effect.share(0, 40.0, true);
  CHECK(at_20 == Approx(0.01 * (end_decades(200.0) - std::log10(2.0)) / (1.0 + 0.01 * std::log10(2.0))));
  CHECK(at_40 == Approx(0.02 * (end_decades(200.0) - std::log10(2.0)) / (1.0 + 0.02 * std::log10(2.0))));
  CHECK(effect.share(0, 35.0, true) == Approx(0.25 * at_20 + 0.75 * at_40));
  CHECK(effect.share(0, 2.0, true) == at_20);
  CHECK(effect.share(0, 58.0, false) == at_40);
}

TEST_CASE("creep is not assessed from other sensors, few frames, short holds, or a run without times") {
  const Example example;
  Dataset other = hold_run(example, {});
  other.sensor_serial = "S2";
  CHECK_THROWS_AS(creep_effect_in(example, {other}), AnalysisError);

  HoldOptions options;
  options.frames = 19;
  const CreepEffect few = creep_effect_in(example, {hold_run(example, options)});
  CHECK_FALSE(few.assessed());
  CHECK_THAT(few.not_assessed, Catch::Contains("fewer than 20 frames"));
  CHECK(few.in_words().empty());
  options.frames = 20;
  CHECK(creep_effect_in(example, {hold_run(example, options)}).assessed());
  CHECK_THAT(creep_effect_in(example, {hold_run(example, options)}, 25.0).not_assessed,
             Catch::Contains("end before twice the 25.0 s"));
  CHECK_THAT(creep_effect_in(example, {hold_run(example, options)}, 0.0).not_assessed,
             Catch::Contains("does not record how long"));
  options.level_psi = 0.4;
  CHECK_THAT(creep_effect_in(example, {hold_run(example, options)}).not_assessed,
             Catch::Contains("a run of creep-hold"));
  CHECK_THAT(creep_effect_in(example, {}).not_assessed, Catch::Contains("one frame is taken a dwell"));
}

TEST_CASE("creep enters the budget as volts of a rectangle, times the inverse's slope") {
  const Example example;
  UncertaintyInputs inputs;
  inputs.creep = creep_effect_in(example, {hold_run(example, {})});
  const Uncertainty with =
      assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate), inputs);
  const Uncertainty without = assess_uncertainty(example.dataset, example.fit, record_with_reference(kWithCertificate));
  for (const bool up : {true, false}) {
    const Budget& budget = with.level(30.0, up)->median;
    const Contribution* row = row_of(budget, UncertaintySource::kCreep);
    REQUIRE(row != nullptr);
    const auto taxel = static_cast<std::size_t>(budget.taxel);
    const ElamModel& model = *elam_of(example.fit.taxels[taxel]);
    const ElamCurve curve =
        up ? ElamCurve(model, true, model.x0(), model.y0()) : ElamCurve(model, false, model.xu(), model.yu());
    const double width = inputs.creep.share(taxel, 30.0, up) * (curve.output(30.0) - model.y0());
    // Half of it is taken off, half of it is the half-width.
    CHECK(row->width == Approx(0.5 * width));
    const double known = (up ? 0.5 : -0.5) * width * row->sensitivity;
    CHECK(budget.error_psi - without.level(30.0, up)->error_psi[taxel] == Approx(known));
    CHECK(row->divisor == Approx(std::sqrt(3.0)));
    CHECK(row->sensitivity == row_of(budget, UncertaintySource::kNoise)->sensitivity);
    CHECK(row->u_psi == Approx(0.5 * width / std::sqrt(3.0) * row->sensitivity));
    CHECK(std::isinf(row->dof));
    CHECK(budget.combined_psi > without.level(30.0, up)->median.combined_psi);
  }
  CHECK(with.missing[static_cast<std::size_t>(UncertaintySource::kCreep)].empty());
  CHECK_THAT(with.from[static_cast<std::size_t>(UncertaintySource::kCreep)], Catch::Contains("40.0 psi loading"));
}
