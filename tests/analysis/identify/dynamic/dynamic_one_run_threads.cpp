// Creep from the fitted run: against plants of known creep, and where there is none.
#include "analysis/identify/dynamic/own_creep.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/studies/contact_results.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace synthetic;

namespace {

DynamicArray creeping(double share, double slowest_s) {
  DynamicArray array = dynamic_array(kTaxels);
  array.dynamics.creep_s = creep_times(slowest_s);
  array.dynamics.creep_share.fill(share);
  for (DynamicTaxel& taxel : array.taxels) taxel.creep_scale = 1.0;
  return array;
}

// The paper's two sequences, twice each: 57 minutes.
Dataset long_run(const DynamicArray& array) {
  const std::vector<double> down = way_along({0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0}, 2.0);
  const std::vector<double> up =
      way_along({0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0}, 2.0);
  return run_of(array, {{"descending", {{down}, {down}}}, {"ascending", {{up}, {up}}}}, 1);
}

double total(const Dynamics& d) { return std::accumulate(d.creep_share.begin(), d.creep_share.end(), 0.0); }

double plain_error(const Dataset& fitted, const Dataset& other) {
  FitOptions plain;
  plain.model = "preisach";
  plain.identify.linearise = true;
  return evaluate(other, fit_array(fitted, plain)).mean_error_psi;
}

}  // namespace

TEST_CASE("a run that passes the same levels again and again tells its creep, and the slowest of its times",
          "[dynamic]") {
  for (const double slowest : {300.0, 1000.0}) {
    const DynamicArray array = creeping(0.05, slowest);
    const Dataset fitted = long_run(array);
    const auto runs = runs_of(array);
    const SensorModel model = fit_dynamic_alone(fitted);
    const Dynamics& own = model.dynamics->shared;
    INFO(slowest << " s: found " << own.creep_s.back() << " s, " << total(own));
    CHECK(own.creep_s.back() == Approx(slowest));
    CHECK(total(own) == Approx(0.15).epsilon(0.25));
    CHECK(own.lag_share == 0.0);
    CHECK(in_time(*model.dynamics));
    const double error = evaluate(runs.other, model).mean_error_psi, plain = plain_error(fitted, runs.other);
    INFO(error << " psi, with creep left in " << plain);
    CHECK(error < 0.2 * plain);

    // Holds of five minutes cannot tell a time of 1000 s: then the fitted run does.
    const SensorModel three = fit_dynamic(fitted, runs.rate, runs.creep);
    const double of_three = evaluate(runs.other, three).mean_error_psi;
    INFO(of_three << " psi from three runs, slowest " << three.dynamics->shared.creep_s.back() << " s");
    CHECK(three.dynamics->shared.lag_share > 0.0);
    if (slowest > 300.0) CHECK(creep_of_fitted_run(*three.dynamics));
    CHECK(three.dynamics->shared.creep_s.back() == Approx(slowest));
    CHECK(of_three < 0.2 * plain);
  }
}

TEST_CASE("a run of two paces and a hold tells lag and each taxel's creep", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const std::vector<double> loop = way_along({0, 60, 0}, 4.0);
  const std::vector<double> inner = way_along({0, 60, 10, 60, 30, 60, 50, 60, 0, 10, 0, 30, 0, 50, 0}, 2.0);
  const Dataset fitted = run_of(array,
                                {{"loops", {{loop, 1.4}, {loop, 4.3}, {loop, 1.4}}},
                                 {"inner-loops", {{inner, 1.4}}},
                                 {"hold", {{{60, 0}, 2.0, 31}}}},
                                1);
  const SensorModel model = fit_dynamic_alone(fitted);
  CHECK(undoes_lag(*model.dynamics));
  // No further run's: what a short hold tells is no evidence of longer ones.
  CHECK((model.dynamics->rate.run == 0 && model.dynamics->creep.run == 0));
  const Dataset other = runs_of(array).other;
  const double error = evaluate(other, model).mean_error_psi, plain = plain_error(fitted, other);
  INFO(error << " psi, with lag and creep left in " << plain);
  CHECK(error < 0.6 * plain);
  double scales = 0.0;
  for (std::size_t t = 0; t < kTaxels; ++t) scales += model.taxels[t].creep_scale / static_cast<double>(kTaxels);
  CHECK(scales == Approx(1.0).margin(0.1));  // over the array's
}

TEST_CASE("creep is left in where a run tells none, no times, or is too short", "[dynamic]") {
  const DynamicArray still = creeping(0.0, 300.0), array = creeping(0.05, 300.0);
  CHECK_FALSE(in_time(*fit_dynamic_alone(long_run(still)).dynamics));
  Dataset timeless = long_run(array);
  CHECK(undoes_creep(*fit_dynamic_alone(timeless).dynamics));
  for (SequenceData& sequence : timeless.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.time_s = sample.held_s = 0.0;
  CHECK_FALSE(undoes_creep(*fit_dynamic_alone(timeless).dynamics));
  Dataset fast = long_run(array);
  for (SequenceData& sequence : fast.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.time_s *= 0.1;
  CHECK_FALSE(undoes_creep(*fit_dynamic_alone(fast).dynamics));
  // Levels that begin above 0: creep counts from the unloaded film.
  Dataset above = long_run(array);
  for (SequenceData& sequence : above.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) {
        sample.setpoint_psi += 10.0;
        sample.reference_psi += 10.0;
      }
  CHECK_FALSE(undoes_creep(*fit_dynamic_alone(above).dynamics));
}

TEST_CASE("an array under an object is read with its creep undone, which goes on while the object is off",
          "[dynamic]") {
  const DynamicArray array = creeping(0.05, 300.0);
  const SensorModel fit = fit_dynamic_alone(long_run(array));
  const std::vector<double> way = way_along({0, 40, 0, 40, 0, 40, 0}, 8.0);
  const Dataset pressed = run_of(array, {{"press", {{way, 20.0}}}}, 5);
  const Repeat& repeat = pressed.sequences.front().repeats.front();
  PressRun run;
  run.run = 5;
  run.origin = pressed.origin;
  run.sensor_serial = pressed.sensor_serial;
  run.scanner_serial = pressed.scanner_serial;
  run.rows = pressed.rows;
  run.columns = pressed.columns;
  const ArrayGeometry geometry{2.0, 10.0};
  const double newtons = static_cast<double>(kTaxels) * 10.0 * kNewtonPerPsiMm2;
  for (std::size_t i = 1; i < way.size(); ++i) {
    PressFrame frame;
    frame.time_s = repeat.steps[i].time_s;
    frame.repeat = static_cast<int>((i - 1) / 10);
    frame.rising = way[i] > way[i - 1];
    frame.target_n = frame.force_n = newtons * way[i];
    frame.volts.assign(repeat.volts.begin() + static_cast<std::ptrdiff_t>(i * kTaxels),
                       repeat.volts.begin() + static_cast<std::ptrdiff_t>((i + 1) * kTaxels));
    run.frames.push_back(std::move(frame));
  }
  const double timed = contact_result(run, fit, geometry).compensated_mean_error_n;
  for (PressFrame& frame : run.frames) frame.time_s = 0.0;
  const double timeless = contact_result(run, fit, geometry).compensated_mean_error_n;
  INFO(timed / newtons << " psi, without times " << timeless / newtons);
  CHECK(timed < 0.5 * timeless);
  CHECK(timed < 1.0 * newtons);
}
