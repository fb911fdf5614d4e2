#include "analysis/identify/stored/model_document.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/statistics/scoring/model_score.h"
#include "analysis/statistics/sensor/drift.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset run_of_two(unsigned seed = 1, double gain = 1.0, double zero = 0.0) {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 2;
  RunOptions run_options;
  run_options.repeats = 2;
  run_options.seed = seed;
  run_options.gain = gain;
  Dataset dataset = run(Array(options), run_options);
  for (SequenceData& sequence : dataset.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (double& volts : repeat.volts) volts += zero;
  return dataset;
}

}  // namespace

TEST_CASE("a model of every kind goes to text and back bit for bit, and predicts the same bits") {
  Histories histories = histories_of(run_of_two());
  histories.content_sha256 = "0123456789abcdef";
  for (const std::string name : model_names()) {
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

TEST_CASE("the result does not depend on the number of threads") {
  const Histories histories = histories_of(run_of_two());
  CHECK(to_text(fit_models("poly", histories, {}, {}, 1)) == to_text(fit_models("poly", histories, {}, {}, 3)));
}

TEST_CASE("a score counts every sample but turning points, by hold time and rate where times are known") {
  const SensorModel document = fit_models("elam", histories_of(run_of_two()), {"descending"}, {});
  Histories later = histories_of(run_of_two(2));
  for (TaxelHistories& taxel : later.taxels)
    for (History& history : taxel.score)
      for (std::size_t i = 0; i < history.x.size(); ++i) {
        history.time_s[i] = 2.0 * static_cast<double>(i);
        history.held_s[i] = i % 2 == 0 ? 0.2 : 2.0;
      }
  const ModelScore score = score_model(document, later, {"ascending"});
  CHECK(score.count == 2);
  CHECK(score.taxels.direct.samples == 2 * 2 * 450);  // taxels, repeats, steps after the first
  CHECK(score.mean.compensated.samples == 2 * 450);
  CHECK(score.taxels.compensated.mean() < 0.3 * score.taxels.raw.mean());
  REQUIRE(score.taxels.by_hold.size() == 2);
  CHECK((score.taxels.by_hold[0].low == Approx(0.2) && score.taxels.by_hold[1].low == Approx(2.0)));
  CHECK_FALSE(score.taxels.by_rate.empty());
}

TEST_CASE("cross-validation of ELAM on data of its own kind is nearly as good as its fit") {
  const Histories histories = histories_of(run_of_two());
  const FitData data = fit_data_of(histories.taxels[0], {});
  const ModelFit fit = identify("elam", data);
  const ErrorSum crossed = cross_validate("elam", data, {});
  CHECK(crossed.samples == 150);  // five inner branches each way
  CHECK(crossed.mean() < 3.0 * fit.mean_error + 0.002 * fit.full_scale);
  CHECK(cross_validate("monotone", data, {}).mean() > 3.0 * crossed.mean());
}

TEST_CASE("a later run shows whether zero, gain or a new fit is needed, and an adjusted model corrects it") {
  const Histories first = histories_of(run_of_two());
  const SensorModel document = fit_models("elam", first, {}, {});
  const auto verdict = [&](double gain, double zero) {
    return drift_of(document, histories_of(run_of_two(2, gain, zero))).verdict;
  };
  CHECK(verdict(1.0, 0.0) == DriftVerdict::kGood);
  CHECK(verdict(1.0, 0.1) == DriftVerdict::kZero);
  CHECK(verdict(0.9, 0.05) == DriftVerdict::kGain);

  Histories later = histories_of(run_of_two(2, 0.9, 0.05));
  later.content_sha256 = "fedcba9876543210";
  const Drift drift = drift_of(document, later);
  CHECK(drift.taxels.front().gain == Approx(0.9).margin(0.005));
  CHECK(drift.taxels.front().zero == Approx(0.05).margin(0.01));
  CHECK(std::abs(drift.taxels.front().gain - 0.9) < 20 * drift.taxels.front().gain_u);
  const std::string parent = sha256_of(document);
  const SensorModel child = adjusted(fit_models("elam", first, {}, {}), drift, later, true);
  CHECK(child.parent_sha256 == parent);
  CHECK_THAT(child.adjustment, Catch::Contains("run 2") && Catch::Contains("fedcba987654"));
  CHECK(drift_of(child, later).verdict == DriftVerdict::kGood);
  CHECK(document_from_text(to_text(child), "c.json").taxels[0].gain == child.taxels[0].gain);
  const ModelScore before = score_model(document, later, {}), after = score_model(child, later, {});
  CHECK(after.taxels.compensated.mean() < 0.5 * before.taxels.compensated.mean());

  Histories warped = histories_of(run_of_two(3));
  for (TaxelHistories& taxel : warped.taxels)
    for (History& history : taxel.score)
      for (std::size_t i = 0; i < history.y.size(); ++i) history.y[i] += 0.4 * std::sin(history.x[i] / 5.0);
  CHECK(drift_of(document, warped).verdict == DriftVerdict::kRecalibrate);
}
