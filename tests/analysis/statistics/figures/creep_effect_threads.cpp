// Creep in the budget: shares by hand from outputs by formula, and what keeps them from being assessed.
#include "analysis/statistics/figures/creep_effect.h"

#include <catch2/catch.hpp>

#include "analysis/error.h"
#include "tests/analysis/support/effect_runs.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace effect_runs;

namespace {

CreepEffect creep_effect_in(const Example& example, const std::vector<Dataset>& runs, double read_after_s = 2.0) {
  return creep_effect_of(read_after(example.dataset, read_after_s), runs, example.fit);
}

}  // namespace

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
  CHECK_FALSE(creep_effect_in(example, {hold_run(example, options)}, 25.0).not_assessed.empty());
  CHECK_FALSE(creep_effect_in(example, {hold_run(example, options)}, 0.0).not_assessed.empty());
  options.level_psi = 0.4;
  CHECK_THAT(creep_effect_in(example, {hold_run(example, options)}).not_assessed,
             Catch::Contains("a run of creep-hold"));
  CHECK_FALSE(creep_effect_in(example, {}).not_assessed.empty());
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
