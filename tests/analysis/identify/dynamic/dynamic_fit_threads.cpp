// The dynamic model of an array from its three runs, against plants of known truth; how it is kept, and streamed.
#include "analysis/identify/dynamic/dynamic_alone.h"

#include <catch2/catch.hpp>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/scoring/model_score.h"
#include "analysis/statistics/sensor/drift.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace synthetic;

TEST_CASE("the dynamic model of an array finds its plants, is kept whole, and reads a way of its own", "[dynamic]") {
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

  DynamicFitOptions one_thread;
  one_thread.threads = 1;
  const std::string text = to_text(model);
  CHECK(to_text(fit_dynamic(runs.fitted, runs.rate, runs.creep, one_thread)) == text);
  const SensorModel again = document_from_text(text, "m.json");
  CHECK(to_text(again) == text);

  // Its stream against Preisach on the linearised output that knows no time, on a way that none of them has seen.
  FitOptions still;
  still.model = "preisach";
  still.identify.linearise = true;
  const double error = evaluate(runs.other, again).mean_error_psi;
  const double still_error = evaluate(runs.other, fit_array(runs.fitted, still)).mean_error_psi;
  INFO(error << " psi, without lag and creep " << still_error);
  CHECK(error < 0.25);
  CHECK(error < 0.5 * still_error);
}

TEST_CASE("a falling sensor and an adjusted model stream like the one that they come from", "[dynamic]") {
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

TEST_CASE("a dynamic model is scored, checked and adjusted with creep and lag undone", "[dynamic]") {
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

TEST_CASE(
    "without runs of lag and creep the dynamic model is made of one run, which needs no times if it tells no creep",
    "[dynamic]") {
  DynamicArray array = dynamic_array(kTaxels);
  array.dynamics.creep_share = {};
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic_alone(runs.fitted);
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
