// Fitted models of every kind: figures, verdicts, frames and storage for every model that can be inverted.

#include <catch2/catch.hpp>

#include <cmath>

#include "analysis/identify/histories.h"
#include "analysis/identify/residuals.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

Dataset run_of_two(unsigned seed, int repeats = 5) {
  return run(Array({.rows = 1, .columns = 2}), {.seed = seed, .repeats = repeats});
}

SensorModel fit_of(const Dataset& data, const std::string& model, int threads = 0) {
  return fit_array(data, fit_by(model, {.starts = 2}, threads));
}

}  // namespace

TEST_CASE("evaluate: every model has a finite error on a held-out run, ELAM and GPI a smaller one than monotone") {
  const Dataset fitted = run_of_two(1), held_out = run_of_two(2);
  double monotone = 0.0;
  for (const std::string model : {"monotone", "elam", "gpi", "mpi", "preisach", "poly"}) {
    INFO(model);
    const SensorModel fit = fit_of(fitted, model);
    REQUIRE(fit.fitted().size() == 2);
    const Evaluation e = evaluate(held_out, fit);
    CHECK((std::isfinite(e.mean_error_psi) && e.mean_error_psi > 0.0));
    CHECK(e.traces.size() == held_out.sequences.size());
    if (model == "monotone") monotone = e.mean_error_psi;
    if (model == "elam" || model == "gpi") CHECK(e.mean_error_psi < monotone);
  }
}

TEST_CASE("histories of a run: contain averages to fit, measured repeats to score, and a mean taxel") {
  const Dataset dataset = run(Array({.rows = 2, .columns = 2}), {.repeats = 2});
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

TEST_CASE("model document: every model kind is read back bit for bit, and predicts the same") {
  Histories histories = histories_of(run_of_two(1, 2));
  histories.content_sha256 = "0123456789abcdef";
  for (const std::string& name : model_names()) {
    INFO(name);
    const SensorModel document = fit_models(name, histories, {}, {.starts = 2});
    const std::string text = to_text(document);
    const SensorModel back = document_from_text(text, "m.json");
    CHECK(to_text(back) == text);
    CHECK(sha256_of(back) == sha256_of(document));
    const History& history = histories.taxels[0].score[0];
    CHECK(predict(*back.taxels[0].fit.model, history.x) == predict(*document.taxels[0].fit.model, history.x));
    CHECK((back.validity.input && back.validity.input->high == Approx(60.0)));
  }
}

TEST_CASE("fit_models: the result does not depend on the number of threads") {
  const Histories histories = histories_of(run_of_two(1, 2));
  CHECK(to_text(fit_models("poly", histories, {}, {}, 1)) == to_text(fit_models("poly", histories, {}, {}, 3)));
}

TEST_CASE("cross-validation: the error of ELAM on ELAM's data is at most 3 times that of its fit") {
  const Histories histories = histories_of(run_of_two(1, 2));
  const FitData data = fit_data_of(histories.taxels[0], {});
  const ModelFit fit = identify("elam", data);
  const ErrorSum crossed = cross_validate("elam", data, {});
  CHECK(crossed.samples == 150);  // five inner branches each way
  CHECK(crossed.mean() < 3.0 * fit.mean_error + 0.002 * fit.full_scale);
  CHECK(cross_validate("monotone", data, {}).mean() > 3.0 * crossed.mean());
}
