// Fitted models of every kind: figures, verdicts, frames and storage for every model that can be inverted.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/histories.h"
#include "analysis/identify/residuals.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/evaluation.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset array_run(unsigned seed) {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 2;
  RunOptions how;
  how.seed = seed;
  return run(Array(options), how);
}

FitOptions by(const std::string& model) {
  FitOptions options;
  options.model = model;
  options.identify.starts = 2;
  return options;
}

}  // namespace

TEST_CASE("evaluate: every model has a finite error on a held-out run, ELAM and GPI a smaller one than monotone") {
  const Dataset fitted = array_run(1), held_out = array_run(2);
  double monotone = 0.0;
  for (const std::string model : {"monotone", "elam", "gpi", "mpi", "preisach", "poly"}) {
    INFO(model);
    const SensorModel fit = fit_array(fitted, by(model));
    REQUIRE(fit.fitted().size() == 2);
    const Evaluation e = evaluate(held_out, fit);
    CHECK((std::isfinite(e.mean_error_psi) && e.mean_error_psi > 0.0));
    CHECK(e.traces.size() == held_out.sequences.size());
    if (model == "monotone") monotone = e.mean_error_psi;
    if (model == "elam" || model == "gpi") CHECK(e.mean_error_psi < monotone);
  }
}

namespace {

Dataset small_run() {
  ArrayOptions options;
  options.rows = options.columns = 2;
  RunOptions run_options;
  run_options.repeats = 2;
  return run(Array(options), run_options);
}

}  // namespace

TEST_CASE("histories of a run: contain averages to fit, measured repeats to score, and a mean taxel") {
  const Dataset dataset = small_run();
  const Histories histories = histories_of(dataset);
  REQUIRE(histories.taxels.size() == 5);
  CHECK(histories.sequences == std::vector<std::string>{"descending", "ascending"});
  const TaxelHistories& first = histories.taxels.front();
  CHECK((first.fit.size() == 2 && first.score.size() == 4 && first.usable()));
  CHECK(first.fit[0].x[3] == dataset.sequences[0].repeats[0].steps[3].setpoint_psi);
  CHECK(first.score[1].x[3] == dataset.sequences[0].repeats[1].steps[3].reference_psi);
  CHECK(first.score[1].y[3] == dataset.sequences[0].repeats[1].volts[3 * 4]);
  const TaxelHistories& mean = histories.taxels.back();
  CHECK(mean.taxel == kMeanTaxel);
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += histories.taxels[i].fit[0].y[7];
  CHECK(mean.fit[0].y[7] == Approx(sum / 4));
  CHECK(mean.noise == Approx(first.noise / 2));
}

// The models' residuals on a plant of another class, in the uncertainty of their streams, and how they are stored.

namespace {

SensorModel fit_of(const Dataset& data, const std::string& model, int threads = 0) {
  FitOptions options;
  options.model = model;
  options.identify.starts = 2;
  options.threads = threads;
  return fit_array(data, options);
}

struct Held {
  double with = 0.0, without = 0.0;  // shares of the samples within twice the uncertainty, with and without residual
};

// Of a way of its own, that no model was fitted on.
Held held_of(const SensorModel& model, const Dataset& data) {
  SensorModel alone = model;
  for (ModelTaxel& taxel : alone.taxels) taxel.residual_psi = 0.0;
  double with = 0.0, without = 0.0, all = 0.0;
  const auto width = static_cast<std::size_t>(data.taxels());
  for (const std::size_t t : model.fitted()) {
    const auto one = compensator_of(model, model.taxels[t]), other = compensator_of(alone, alone.taxels[t]);
    const auto volts = [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * width + t]; };
    const auto count = [&](double& held) {
      return [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        const double psi = data.sequences[s].repeats[r].steps[i].reference_psi;
        held += std::abs(now.pressure_psi - psi) <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
      };
    };
    stream_samples(data, *one, volts, count(with));
    stream_samples(data, *other, volts, count(without));
    all += static_cast<double>(data.sequences.front().repeats.front().steps.size());
  }
  return {with / all, without / all};
}

}  // namespace

TEST_CASE("residuals: twice the uncertainty covers over 85 % of unfitted samples, noise alone under 70 %") {
  // Relays behind a divider, with lag and creep: none of the models.
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  for (const char* const name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"}) {
    const SensorModel model = fit_of(runs.fitted, name);
    const Held held = held_of(model, runs.other);
    INFO(name << ": " << 100.0 * held.with << " %, by noise alone " << 100.0 * held.without << " %");
    CHECK(held.with > 0.85);
    CHECK(held.without < 0.7);
    CHECK(held.without < held.with - 0.2);
  }
}

TEST_CASE("residuals: do not depend on the number of threads, and are stored in documents") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  for (const char* const name : {"elam", "preisach"})
    CHECK(to_text(fit_of(runs.fitted, name, 1)) == to_text(fit_of(runs.fitted, name, 3)));
  const SensorModel elam = fit_of(runs.fitted, "elam");
  REQUIRE(elam.taxels.size() == kTaxels + 1);
  const SensorModel document = document_from_text(to_text(elam), "m.json");
  for (std::size_t t = 0; t < elam.taxels.size(); ++t) {
    CHECK(elam.taxels[t].residual_psi > 0.0);
    CHECK(document.taxels[t].residual_psi == elam.taxels[t].residual_psi);
  }
}

TEST_CASE("FrameCompensator: a start in mid-run is unknown, and so is the state after many lost frames") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const Repeat& whole = runs.other.sequences.front().repeats.front();
  const SensorModel model = fit_of(runs.fitted, "preisach");
  FrameCompensator stream = frames_of(model, 1.0, 2);
  std::vector<float> pressure(kTaxels), uncertainty(kTaxels);
  std::vector<std::uint16_t> status(kTaxels);
  const FrameCompensator::Output output{pressure, uncertainty, status};
  const auto frame = [&](std::size_t i) {
    std::vector<float> volts;
    for (std::size_t t = 0; t < kTaxels; ++t) volts.push_back(static_cast<float>(whole.volts[i * kTaxels + t]));
    stream.frame(volts, 2.6, output);
  };
  const auto unknown = [&] { return (status[0] & kTaxelUnknown) != 0; };
  frame(20);
  CHECK(unknown());
  for (std::size_t i = 21; i <= 60; ++i) frame(i);  // to the top, and to 0
  CHECK_FALSE(unknown());
  for (std::size_t i = 61; i < 75; ++i) frame(i);
  stream.lost_frame(2.6, output);
  stream.lost_frame(2.6, output);
  frame(75);
  CHECK_FALSE(unknown());
  for (int i = 0; i < 3; ++i) stream.lost_frame(2.6, output);
  frame(76);
  CHECK(unknown());
}
