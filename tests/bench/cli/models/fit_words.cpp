// One fitted model as `fit` tells it as JSON, of a model that is known number by number.
#include "bench/cli/models/fit_words.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "analysis/models/linearised.h"
#include "analysis/models/mpi.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

analysis::ModelTaxel taxel_with_divider(int number, double c) {
  analysis::ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = analysis::TaxelStatus::kFitted;
  auto inner = std::make_shared<analysis::MpiModel>(analysis::MpiParameters{0.1, 0.0, 0.0, 3.0, 5.0}, 0.0, 60.0, 0.0);
  analysis::Divider divider;
  divider.per_amplitude = c;
  taxel.fit.model = std::make_unique<analysis::LinearisedModel>(divider, std::move(inner));
  taxel.fit.j = 0.125;
  taxel.fit.mean_error = 0.02;
  taxel.fit.max_error = 0.06;
  taxel.fit.full_scale = 2.0;
  const std::array<double, 2> x = {0.0, 60.0}, y = {0.5, 2.0};
  taxel.ascending = analysis::PatternCurve(x, y, 0.5, 2.0);
  return taxel;
}

// 4 x 4 taxels, of which all but 0 and 1 are dead, and the mean taxel.
analysis::SensorModel array_model() {
  analysis::SensorModel model;
  model.model = "mpi";
  model.run = 3;
  model.origin = "simulated";
  model.rows = model.columns = 4;
  model.input_unit = "psi";
  model.output_unit = "V";
  model.taxels.push_back(taxel_with_divider(0, 0.0));
  model.taxels.push_back(taxel_with_divider(1, 0.25));
  for (int taxel = 2; taxel < 16; ++taxel) {
    analysis::ModelTaxel& dead = model.taxels.emplace_back();
    dead.taxel = taxel;
    dead.status = analysis::TaxelStatus::kDead;
  }
  model.taxels.push_back(taxel_with_divider(analysis::kMeanTaxel, 0.125));
  return model;
}

}  // namespace

TEST_CASE("fit words: the JSON of a fit") {
  analysis::SensorModel model = array_model();
  model.repeats = {{"up", 0.001, 0.0002, 0.003, 0.0004, true}};
  FittedRun fitted;
  fitted.model = &model;
  fitted.evaluations.emplace_back();
  nlohmann::ordered_json json;
  add_fitted_json(fitted, json);
  tests::check_members(json, R"({"run": 3, "taxels": 16, "fitted_taxels": 2})");
  CHECK(json.at("left_out").size() == 14);
  tests::check_members(json.at("left_out").at(0), R"({"taxel": 2, "row": 0, "column": 2, "status": "dead"})");
  const auto& mean = json.at("mean_taxel");
  tests::check_members(mean, R"({"status": "fitted", "j_v2": 0.125, "mean_error_v": 0.02, "max_error_v": 0.06,
                          "full_scale_v": 2.0, "mean_error_fs": 0.01, "c_per_v": 0.125})");
  CHECK_FALSE(mean.contains("alpha_d"));
  CHECK(json.at("evaluations").size() == 1);
  CHECK(json.at("repeats").at(0) == nlohmann::ordered_json::parse(
                                        R"({"sequence": "up", "first_differs": true, "shift_v": 0.001,
                                            "uncertainty_v": 0.0002, "rms_v": 0.003, "others_rms_v": 0.0004})"));
  CHECK(json.at("verdicts").empty());
  CHECK_FALSE(json.contains("judgement"));
  analysis::SensorModel bare = array_model();
  bare.taxels.back().ascending = {};  // its full scale is not known
  FittedRun unscaled;
  unscaled.model = &bare;
  nlohmann::ordered_json without;
  add_fitted_json(unscaled, without);
  CHECK(without.at("mean_taxel").at("mean_error_fs") == 0.0);
  fitted.judgement = analysis::by_hand::judgement_of(
      {analysis::by_hand::judged_figure(2, analysis::Criterion::kMeanError, 1.0, 2.0, analysis::Verdict::kPass)});
  nlohmann::ordered_json judged;
  add_fitted_json(fitted, judged);
  CHECK(judged.at("verdicts").at(0).at("shown") == "simulated pass");
  CHECK(judged.at("judgement").at("overall") == "pass");
}
