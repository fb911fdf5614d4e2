#include "analysis/identify/stored/model_document.h"

#include <catch2/catch.hpp>

#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset run_of_two() {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 2;
  RunOptions run_options;
  run_options.repeats = 2;
  return run(Array(options), run_options);
}

}  // namespace

TEST_CASE("model document: every model kind is read back bit for bit, and predicts the same") {
  Histories histories = histories_of(run_of_two());
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
  const Histories histories = histories_of(run_of_two());
  CHECK(to_text(fit_models("poly", histories, {}, {}, 1)) == to_text(fit_models("poly", histories, {}, {}, 3)));
}

TEST_CASE("cross-validation: ELAM on data of its own kind is nearly as good as its fit") {
  const Histories histories = histories_of(run_of_two());
  const FitData data = fit_data_of(histories.taxels[0], {});
  const ModelFit fit = identify("elam", data);
  const ErrorSum crossed = cross_validate("elam", data, {});
  CHECK(crossed.samples == 150);  // five inner branches each way
  CHECK(crossed.mean() < 3.0 * fit.mean_error + 0.002 * fit.full_scale);
  CHECK(cross_validate("monotone", data, {}).mean() > 3.0 * crossed.mean());
}
