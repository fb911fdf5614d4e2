// The dynamic model of an array from its three runs, against plants of known truth; how it is kept, and streamed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/scoring/score.h"
#include "analysis/statistics/sensor/drift.h"
#include "analysis/statistics/studies/contact.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// Of Preisach on the linearised output, which knows no time.
double plain_error(const Dataset& fitted, const Dataset& other) {
  return evaluate(other, fit_array(fitted, fit_by("preisach", {.linearise = true}))).mean_error_psi;
}

}  // namespace

TEST_CASE("fit_dynamic: recovers known plants, is stored without loss, and reads another path within 0.25 psi",
          "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  CHECK(model.model == kDynamicModel);
  CHECK(label_of(model) == "dynamic");
  REQUIRE(model.fitted().size() == kTaxels);
  REQUIRE(model.dynamics);
  CHECK(model.dynamics->rate.run == 2);
  CHECK(model.dynamics->creep.run == 3);
  const Dynamics &own = model.dynamics->shared, &truth = array.dynamics;
  double creep = 0.0, true_creep = 0.0;
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    creep += own.creep_share[j];
    true_creep += truth.creep_share[j];
  }
  CHECK(creep == Approx(0.9 * true_creep).epsilon(0.2));  // the four taxels' mean scale is 0.875
  CHECK(own.lag_share == Approx(0.06).epsilon(0.4));
  for (std::size_t t = 0; t < kTaxels; ++t) {
    REQUIRE(linearised_of(model.taxels[t]) != nullptr);
    CHECK(linearised_of(model.taxels[t])->divider().per_amplitude ==
          Approx(array.taxels[t].divider.per_amplitude).epsilon(0.1));
    CHECK(model.taxels[t].residual_psi > 0.0);
  }
  // Holds of five minutes and the fast loop are within its validity.
  CHECK(model.validity.hold_s->high > 250.0);
  CHECK(model.validity.hold_s->low < 1.0);

  const std::string text = to_text(model);
  CHECK(to_text(fit_dynamic(runs.fitted, runs.rate, runs.creep, {.threads = 1})) == text);
  const SensorModel again = document_from_text(text, "m.json");
  CHECK(to_text(again) == text);

  // Its stream against Preisach on the linearised output that knows no time, on a way that none of them has seen.
  const double error = evaluate(runs.other, again).mean_error_psi;
  const double still_error = plain_error(runs.fitted, runs.other);
  INFO(error << " psi, without lag and creep " << still_error);
  CHECK(error < 0.25);
  CHECK(error < 0.5 * still_error);
}

TEST_CASE("fit_dynamic: a falling sensor and an adjusted model give the same errors as the original", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array), falling = runs_of(array, -1.0);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  const SensorModel negated = fit_dynamic(falling.fitted, falling.rate, falling.creep);
  CHECK(negated.falling);
  const double error = evaluate(runs.other, model).mean_error_psi;
  CHECK(evaluate(falling.other, negated).mean_error_psi == Approx(error).epsilon(1e-3));

  SensorModel moved = model;
  for (ModelTaxel& taxel : moved.taxels) {
    taxel.zero = 0.05;
    taxel.gain = 1.3;
  }
  Dataset scaled = runs.other;
  for (double& volts : scaled.sequences.front().repeats.front().volts) volts = 0.05 + 1.3 * volts;
  for (ModelTaxel& taxel : moved.taxels) taxel.noise *= 1.3;
  CHECK(evaluate(scaled, moved).mean_error_psi == Approx(error).epsilon(1e-6));
}

TEST_CASE("dynamic model: scoring, drift check and adjustment remove creep and lag first", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  const Histories other = histories_of(runs.other);
  const ModelScore score = score_model(model, other, {});
  CHECK(score.count == kTaxels);
  CHECK(score.taxels.compensated.mean() == Approx(evaluate(runs.other, model).mean_error_psi).epsilon(0.1));
  // The static models know nothing of creep and lag, whose share of the output is what they would be off by.
  SensorModel still = model;
  still.dynamics.reset();
  const double undone = score.taxels.free_running.mean(),
               left_in = score_model(still, other, {}).taxels.free_running.mean();
  INFO(undone << " V, with lag and creep " << left_in);
  CHECK(undone < 0.5 * left_in);
  CHECK(drift_of(model, other).verdict == DriftVerdict::kGood);

  // 30 mV of zero and 3 % of gain since then.
  Dataset later = runs.other;
  for (double& v : later.sequences.front().repeats.front().volts) v = 0.03 + 1.03 * v;
  const Histories moved = histories_of(later);
  const Drift drift = drift_of(model, moved);
  for (const TaxelDrift& taxel : drift.taxels) CHECK(taxel.gain == Approx(1.03).margin(0.01));
  const SensorModel child = adjusted(model, drift, moved, true);
  const double before = evaluate(later, model).mean_error_psi, after = evaluate(later, child).mean_error_psi;
  INFO(before << " psi, adjusted " << after);
  CHECK(after < 0.5 * before);
  CHECK(after < 0.25);
}

TEST_CASE("dynamic model of one run: without creep in the run it needs no times, and errs less than ELAM",
          "[dynamic]") {
  DynamicArray array = dynamic_array(kTaxels);
  array.dynamics.creep_share = {};
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic_single_run(runs.fitted);
  REQUIRE(model.dynamics);
  CHECK_FALSE(in_time(*model.dynamics));
  CHECK(model.dynamics->rate.run == 0);
  const std::string text = to_text(model);
  const SensorModel again = document_from_text(text, "m.json");
  CHECK(to_text(again) == text);
  const double error = evaluate(runs.other, again).mean_error_psi,
               elam = evaluate(runs.other, fit_array(runs.fitted)).mean_error_psi;
  INFO(error << " psi, ELAM " << elam);
  CHECK(error < elam);
  Dataset timeless = runs.other;
  for (Sample& sample : timeless.sequences.front().repeats.front().steps) sample.time_s = sample.held_s = 0.0;
  CHECK(evaluate(timeless, again).mean_error_psi == error);
  CHECK(score_model(again, histories_of(runs.other), {}).count == kTaxels);
}

// Creep from the fitted run: against plants of known creep, and where there is none.

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

}  // namespace

TEST_CASE("dynamic model of one run: repeated levels yield the creep and its slowest time constant", "[dynamic]") {
  for (const double slowest : {300.0, 1000.0}) {
    const DynamicArray array = creeping(0.05, slowest);
    const Dataset fitted = long_run(array);
    const auto runs = runs_of(array);
    const SensorModel model = fit_dynamic_single_run(fitted);
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
    CHECK(three.dynamics->shared.creep_s.back() == Approx(slowest));
    CHECK(of_three < 0.2 * plain);
  }
}

TEST_CASE("dynamic model of one run: two rates and a hold yield the lag and each taxel's creep", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const std::vector<double> loop = way_along({0, 60, 0}, 4.0);
  const std::vector<double> inner = way_along({0, 60, 10, 60, 30, 60, 50, 60, 0, 10, 0, 30, 0, 50, 0}, 2.0);
  const Dataset fitted = run_of(array,
                                {{"loops", {{loop, 1.4}, {loop, 4.3}, {loop, 1.4}}},
                                 {"inner-loops", {{inner, 1.4}}},
                                 {"hold", {{{60, 0}, 2.0, 31}}}},
                                1);
  const SensorModel model = fit_dynamic_single_run(fitted);
  CHECK(compensates_lag(*model.dynamics));
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

TEST_CASE("dynamic model of one run: removes no creep if there is none, no times, a short run or a start above 0",
          "[dynamic]") {
  const DynamicArray still = creeping(0.0, 300.0), array = creeping(0.05, 300.0);
  CHECK_FALSE(in_time(*fit_dynamic_single_run(long_run(still)).dynamics));
  Dataset timeless = long_run(array);
  CHECK(compensates_creep(*fit_dynamic_single_run(timeless).dynamics));
  for (SequenceData& sequence : timeless.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.time_s = sample.held_s = 0.0;
  CHECK_FALSE(compensates_creep(*fit_dynamic_single_run(timeless).dynamics));
  Dataset fast = long_run(array);
  for (SequenceData& sequence : fast.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.time_s *= 0.1;
  CHECK_FALSE(compensates_creep(*fit_dynamic_single_run(fast).dynamics));
  // Levels that begin above 0: creep counts from the unloaded film.
  Dataset above = long_run(array);
  for (SequenceData& sequence : above.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) {
        sample.setpoint_psi += 10.0;
        sample.reference_psi += 10.0;
      }
  CHECK_FALSE(compensates_creep(*fit_dynamic_single_run(above).dynamics));
}

TEST_CASE("contact_result: frame times let creep be removed under an object, which halves the force error",
          "[dynamic]") {
  const DynamicArray array = creeping(0.05, 300.0);
  const SensorModel fit = fit_dynamic_single_run(long_run(array));
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

// What a dynamic model says of its own error, against the truth.

namespace {

struct ResidualSum {
  double squares = 0.0, samples = 0.0, covered = 0.0;
  [[nodiscard]] double rms() const { return std::sqrt(squares / samples); }
};

ResidualSum residual_sum(const Dataset& data, const SensorModel& model, std::size_t taxel) {
  ResidualSum sum;
  const auto stream = compensator_of(model, model.taxels[taxel]);
  stream_samples(
      data, *stream, [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * kTaxels + taxel]; },
      [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        const double error = now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi;
        sum.squares += error * error;
        sum.samples += 1.0;
        sum.covered += std::abs(error) <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
      });
  return sum;
}

}  // namespace

TEST_CASE("dynamic model: the stated residual agrees with the error on paths that were not fitted", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  // Two inner branches, which 120 weights follow wherever they go; many; and none.
  const std::vector<double> few = way_along({0, 60, 0, 40, 0, 60, 20, 60, 0}, 4.0);
  const Dataset loops = run_of(array, {{"loops", {{way_along({0, 60, 0}, 4.0)}}}}, 5);
  for (const Dataset& fitted : {run_of(array, {{"few", {{few}}}}, 1), runs.fitted, loops}) {
    const SensorModel model = fit_dynamic_single_run(fitted);
    ResidualSum seen, other;
    double stated2 = 0.0;
    for (std::size_t t = 0; t < kTaxels; ++t) {
      for (auto [sum, data] : {std::pair{&seen, &fitted}, {&other, &runs.other}}) {
        const ResidualSum own = residual_sum(*data, model, t);
        sum->squares += own.squares;
        sum->samples += own.samples;
        sum->covered += own.covered;
      }
      stated2 += model.taxels[t].residual_psi * model.taxels[t].residual_psi / kTaxels;
    }
    INFO(fitted.sequences.front().name << ": stated " << std::sqrt(stated2) << ", fitted leave " << seen.rms()
                                       << ", others " << other.rms() << ", of which "
                                       << 100.0 * other.covered / other.samples << " % within");
    CHECK(std::sqrt(stated2) > 0.5 * other.rms());
    CHECK(std::sqrt(stated2) < 4.0 * other.rms());
    CHECK(other.covered > 0.85 * other.samples);
  }
}

TEST_CASE("dynamic model: twice the uncertainty covers over 90 % of the pressures on another path", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  ResidualSum all;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ResidualSum own = residual_sum(runs.other, model, t);
    all.samples += own.samples;
    all.covered += own.covered;
    all.squares += own.squares;
    // Not by being wide: the residual is no more than a few times the error that is there.
    CHECK(model.taxels[t].residual_psi < 6.0 * own.rms());
  }
  INFO(100.0 * all.covered / all.samples << " % of " << all.samples << " samples, which err by " << all.rms()
                                         << " psi");
  CHECK(all.covered > 0.9 * all.samples);
}

// The residual of a dynamic model by level and direction; what else one run decides.

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

TEST_CASE("residual shape: has two values per interval, larger near the top of the falling branch", "[dynamic]") {
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

TEST_CASE("dynamic model of one run: limits intervals to distinct levels, averages zeros and leaves dead taxels out",
          "[dynamic]") {
  const Dataset run = straight_run(1);
  for (const auto& [cells, intervals] : {std::pair{20, 3U}, {3, 3U}, {2, 2U}}) {
    const SensorModel model = fit_dynamic_single_run(run, {.cells = cells});
    REQUIRE(model.taxels.size() == 4);
    CHECK(film_in(model.taxels[0]).intervals() == intervals);
    CHECK_FALSE(in_time(*model.dynamics));
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

TEST_CASE("fit_dynamic: limits intervals to distinct levels, and errs no more than the model of one run", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const Dataset coarse = run_of(array, {{"coarse", {{way_along({0, 60, 0, 40, 0, 60, 20, 60, 0}, 10.0)}}}}, 1);
  const SensorModel model = fit_dynamic(coarse, runs.rate, runs.creep);
  CHECK(film_in(model.taxels[0]).intervals() == 6);
  CHECK(evaluate(runs.other, model).mean_error_psi <=
        evaluate(runs.other, fit_dynamic_single_run(coarse)).mean_error_psi);
}

TEST_CASE("fit_dynamic: creep seen in a hold but not between passes of the fitted run is not removed", "[dynamic]") {
  DynamicArray array = dynamic_array(kTaxels);
  const Dataset creep = runs_of(array).creep;
  array.dynamics.creep_share = {};
  const Runs runs = runs_of(array);
  CHECK_FALSE(compensates_creep(*fit_dynamic(runs.fitted, runs.rate, creep).dynamics));
}
