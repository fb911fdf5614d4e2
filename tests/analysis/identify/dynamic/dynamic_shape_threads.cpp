// The residual of a dynamic model by level and direction, summed up again from its streams; what else one run decides.
#include <catch2/catch.hpp>
#include <cmath>

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

TEST_CASE("the residual's shape is what streams leave in each interval, over what they leave of a taxel", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  Dataset fitted = runs.fitted;
  fitted.sequences.pop_back();  // none to hold out
  const SensorModel model = fit_dynamic(fitted, runs.rate, runs.creep);
  const std::size_t n = film_in(model.taxels[0]).intervals();
  REQUIRE(model.taxels.size() == kTaxels + 1);
  REQUIRE(model.dynamics->residual_shape.size() == 2 * n);
  std::vector<double> shape(2 * n, 0.0), count(2 * n, 0.0);
  for (std::size_t t = 0; t <= kTaxels; ++t) {
    std::vector<double> squares(2 * n, 0.0), own(2 * n, 0.0);
    double sum = 0.0, samples = 0.0;
    const auto stream = compensator_of(model, model.taxels[t]);
    const auto volts = [&](const Repeat& repeat, std::size_t i) {
      if (t < kTaxels) return repeat.volts[i * kTaxels + t];
      double mean = 0.0;
      for (std::size_t k = 0; k < kTaxels; ++k) mean += repeat.volts[i * kTaxels + k] / kTaxels;
      return mean;
    };
    stream_samples(fitted, *stream, volts, [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      const double error = now.pressure_psi - fitted.sequences[s].repeats[r].steps[i].reference_psi;
      const auto at = std::min(n - 1, static_cast<std::size_t>(now.pressure_psi / 60.0 * static_cast<double>(n)));
      squares[stream->ascending() ? at : n + at] += error * error;
      own[stream->ascending() ? at : n + at] += 1.0;
      sum += error * error;
      samples += 1.0;
    });
    CAPTURE(t);
    CHECK(model.taxels[t].residual_psi == Approx(2.0 * std::sqrt(sum / samples)).epsilon(1e-6));
    for (std::size_t k = 0; k < 2 * n && t < kTaxels; ++k) {  // the mean taxel is no further opinion
      shape[k] += squares[k] / (sum / samples);
      count[k] += own[k];
    }
  }
  for (std::size_t k = 0; k < 2 * n; ++k) {
    CAPTURE(k);
    CHECK(model.dynamics->residual_shape[k] == Approx(count[k] > 0.0 ? std::sqrt(shape[k] / count[k]) : 1.0));
  }
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
