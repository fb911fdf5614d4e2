// The residual of a dynamic model by level and direction; what else one run decides.
#include <algorithm>
#include <catch2/catch.hpp>

#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "analysis/statistics/figures/evaluation.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

const PreisachModel& film_in(const ModelTaxel& taxel) {
  const LinearisedModel* const outer = linearised_of(taxel);
  REQUIRE(outer != nullptr);
  return dynamic_cast<const PreisachModel&>(outer->inner());
}

// Straight films over 0 to 60 in steps of 20, a taxel of which is dead.
Dataset straight_run(std::int64_t number) {
  const std::vector<double> way{0, 20, 40, 60, 40, 20, 40, 60, 40, 20, 0, 20, 40, 20, 0, 40, 60, 20, 0, 0};
  Dataset data = walked_run({}, {{0.1, 0.05, 1.0, 0.0}, {0.0, 0.0, 1.0, 0.0}, {0.4, 0.03, 1.0, 0.0}},
                            {{"way", {{way, 2.0}, {way, 2.0}}}}, 60.0);
  data.run = number;
  data.sensor_serial = "S";
  data.scanner_serial = "C";
  // Unloaded outputs of the two repeats that differ: their mean is what counts.
  for (double& volts : data.sequences[0].repeats[1].volts) volts += volts > 0.0 ? 0.002 : 0.0;
  return data;
}

}  // namespace

TEST_CASE("the residual's shape has two numbers an interval, larger where the stream errs by more", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  const std::size_t n = film_in(model.taxels[0]).intervals();
  const std::vector<double>& shape = model.dynamics->residual_shape;
  REQUIRE(shape.size() == 2 * n);
  const auto [least, most] = std::ranges::minmax(shape);
  CHECK((least > 0.5 && least < 1.0 && most > 1.0 && most < 4.0));
  // Where the film is flat, an output means more inputs: near the top, falling.
  CHECK(shape[2 * n - 1] > shape[n + n / 4]);
}

TEST_CASE("of one run: no more intervals than levels tell apart, zeros that are means, a dead taxel as the array",
          "[dynamic]") {
  const Dataset run = straight_run(1);
  for (const auto& [cells, intervals] : {std::pair{20, 3U}, {3, 3U}, {2, 2U}}) {
    DynamicFitOptions options;
    options.cells = cells;
    const SensorModel model = fit_dynamic_alone(run, options);
    REQUIRE(model.taxels.size() == 4);
    CHECK(film_in(model.taxels[0]).intervals() == intervals);
    CHECK_FALSE(in_time(*model.dynamics));
    CHECK_FALSE(creep_of_fitted_run(*model.dynamics));
    CHECK(model.fitted() == std::vector<std::size_t>{0, 2});
    CHECK(model.taxels[0].creep_scale == 1.0);
    CHECK(model.taxels[2].lag_share == 0.0);
    CHECK(model.validity.hold_s->low == 2.0);
    CHECK(model.dynamics->rate.run == 0);
    CHECK(model.dynamics->creep.run == 0);
    // 0 to 60 psi are 3 V and 1.8 V.
    CHECK(model.taxels[0].fit.full_scale == Approx(3.0));
    CHECK(model.taxels[2].fit.full_scale == Approx(1.8));
    CHECK(model.taxels[0].loop_low == Approx(0.101));
  }
}

TEST_CASE("with runs of lag and creep, too: no more intervals than levels tell apart, and no larger error than without",
          "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const Dataset coarse = run_of(array, {{"coarse", {{way_along({0, 60, 0, 40, 0, 60, 20, 60, 0}, 10.0)}}}}, 1);
  const SensorModel model = fit_dynamic(coarse, runs.rate, runs.creep);
  CHECK(film_in(model.taxels[0]).intervals() == 6);
  CHECK(evaluate(runs.other, model).mean_error_psi <= evaluate(runs.other, fit_dynamic_alone(coarse)).mean_error_psi);
}

TEST_CASE("a film that moves in a hold without creeping from pass to pass keeps its outputs", "[dynamic]") {
  DynamicArray array = dynamic_array(kTaxels);
  const Dataset creep = runs_of(array).creep;
  array.dynamics.creep_share = {};
  const Runs runs = runs_of(array);
  CHECK_FALSE(undoes_creep(*fit_dynamic(runs.fitted, runs.rate, creep).dynamics));
}
