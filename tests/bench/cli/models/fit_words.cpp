// One fitted model as `fit` prints it and tells it as JSON, of models that are known number by number.
#include "bench/cli/models/fit_words.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "analysis/models/linearised.h"
#include "analysis/models/mpi.h"

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

analysis::SensorModel with_dynamics(double creep, double other_creep, std::int64_t rate, std::int64_t creep_run) {
  analysis::SensorModel model = array_model();
  analysis::SensorDynamics& dynamics = model.dynamics.emplace();
  dynamics.shared.creep_share = {creep, other_creep, creep};
  dynamics.shared.lag_share = 0.05;
  dynamics.shared.lag_s = 1.25;
  dynamics.rate.run = rate;
  dynamics.creep.run = creep_run;
  return model;
}

}  // namespace

TEST_CASE("fit words: how many taxels have the divider undone, and by which numbers") {
  analysis::SensorModel model = array_model();
  CHECK(linearised_text(model) == "linearised output, u = v / (1 - c v): 1 of 2 taxels, c 0.2500 to 0.2500 1/V");
  model.taxels[0] = taxel_with_divider(0, 0.0625);
  model.output_unit = "";
  CHECK(linearised_text(model) == "linearised output, u = v / (1 - c v): 2 of 2 taxels, c 0.0625 to 0.2500");
  model.taxels.erase(model.taxels.begin(), model.taxels.end() - 1);  // the mean taxel is all there is
  CHECK(linearised_text(model) == "linearised output, u = v / (1 - c v): 1 of 1 taxel, c 0.1250 to 0.1250");
  model.taxels[0] = taxel_with_divider(analysis::kMeanTaxel, 0.0);
  CHECK(linearised_text(model) == "linearised output, u = v / (1 - c v): 0 of 1 taxel");
  model.taxels[0].fit.model.reset();
  CHECK(linearised_text(model).empty());
}

TEST_CASE("fit words: creep and lag, and which runs they are from") {
  CHECK(dynamics_text(array_model()).empty());
  const std::string elements = "creep 1.00 % in 3 s, 2.00 % in 30 s, 1.00 % in 300 s, half of it at 10.0 psi (";
  CHECK(dynamics_text(with_dynamics(0.01, 0.02, 5, 6)) == elements + "run 6); lag 5.0 % in 1.25 s (run 5)");
  CHECK(dynamics_text(with_dynamics(0.01, 0.02, 5, 0)) == elements + "run 0); lag 5.0 % in 1.25 s (run 5)");
  CHECK(dynamics_text(with_dynamics(0.01, 0.02, 0, 6)) == elements + "run 6); lag 5.0 % in 1.25 s (run 0)");
  CHECK(dynamics_text(with_dynamics(0.01, 0.02, 0, 0)) == elements + "from the fitted run); lag is left in");
  CHECK(dynamics_text(with_dynamics(0.0, 0.0, 0, 0)) ==
        "lag and creep are left in: no runs of them were named, and the fitted one tells no creep");
  CHECK_THAT(dynamics_text(with_dynamics(0.0, 0.0, 5, 6)), Catch::StartsWith("creep 0.00 % in 3 s, "));
  CHECK_THAT(dynamics_text(with_dynamics(0.01, 0.01, 5, 6)),
             Catch::Contains("half of it at 10.0 psi (from the fitted run, by taxel from run 6)"));
}

TEST_CASE("fit words: taxels without a model by row and column, twelve of them by name") {
  const analysis::SensorModel model = array_model();
  const std::vector<LeftOut> left_out = left_out_of(model);
  REQUIRE(left_out.size() == 14);
  CHECK((left_out[0].taxel == 2 && left_out[0].row == 0 && left_out[0].column == 2 && left_out[0].status == "dead"));
  CHECK((left_out[13].row == 3 && left_out[13].column == 3));
  FittedRun fitted;
  fitted.model = &model;
  const std::string text = fitted_text(fitted, analysis::PressureUnit::kPsi);
  CHECK_THAT(text, Catch::StartsWith("mpi on run 3 (simulated): 2 of 16 taxels fitted, full scale 2.000 V\nleft out: "
                                     "row 0, column 2 (dead)\nleft out: row 0, column 3 (dead)\n") &&
                       Catch::Contains("left out: row 3, column 1 (dead)\nleft out: 2 more; --json lists all\n") &&
                       !Catch::Contains("row 3, column 2") &&
                       Catch::Contains("mean taxel: 6 parameters; J 0.125 V2, mean error 1.00 % FS, max 3.00 % FS\n"
                                       "linearised output, u = v / (1 - c v): 1 of 2 taxels, c 0.2500 to 0.2500 "
                                       "1/V\n\nhysteresis, % FS "));
  CHECK(text.find("the first repeat") == std::string::npos);
  analysis::SensorModel twelve = array_model();
  twelve.taxels[2] = taxel_with_divider(2, 0.0);
  twelve.taxels[3] = taxel_with_divider(3, 0.0);
  twelve.repeats = {{"up", 0.001, 0.0002, 0.003, 0.0004, true}, {"down", 0.5, 0.5, 0.5, 0.5, false}};
  fitted.model = &twelve;
  const std::string whole = fitted_text(fitted, analysis::PressureUnit::kPsi);
  CHECK(whole.find("more; --json") == std::string::npos);
  CHECK_THAT(whole, Catch::Contains("(dead)\nmean taxel: ") &&
                        Catch::Contains("the first repeat of up differs from the others by 1.00 +- 0.20 mV (3.00 mV "
                                        "rms, others 0.40)\n") &&
                        !Catch::Contains("repeat of down"));
  analysis::SensorModel timed = with_dynamics(0.01, 0.02, 5, 6);
  fitted.model = &timed;
  CHECK_THAT(fitted_text(fitted, analysis::PressureUnit::kKilopascal),
             Catch::Contains("half of it at 68.9 kPa (run 6)"));
}

TEST_CASE("fit words: the JSON of a fit") {
  analysis::SensorModel model = array_model();
  model.repeats = {{"up", 0.001, 0.0002, 0.003, 0.0004, true}};
  FittedRun fitted;
  fitted.model = &model;
  fitted.evaluations.emplace_back();
  nlohmann::ordered_json json;
  add_fitted_json(fitted, json);
  CHECK(json.at("run") == 3);
  CHECK(json.at("taxels") == 16);
  CHECK(json.at("fitted_taxels") == 2);
  CHECK(json.at("left_out").size() == 14);
  CHECK(json.at("left_out").at(0) ==
        nlohmann::ordered_json::parse(R"({"taxel": 2, "row": 0, "column": 2, "status": "dead"})"));
  const auto& mean = json.at("mean_taxel");
  CHECK(mean.at("status") == "fitted");
  CHECK(mean.at("j_v2") == 0.125);
  CHECK(mean.at("mean_error_v") == 0.02);
  CHECK(mean.at("max_error_v") == 0.06);
  CHECK(mean.at("full_scale_v") == 2.0);
  CHECK(mean.at("mean_error_fs") == 0.01);
  CHECK(mean.at("c_per_v") == 0.125);
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
  db::VerdictRecord row;
  row.verdict = "pass";
  fitted.judgement.verdicts = {row};
  nlohmann::ordered_json judged;
  add_fitted_json(fitted, judged);
  CHECK(judged.at("verdicts").at(0).at("shown") == "simulated pass");
  CHECK(judged.at("judgement").at("overall") == "pass");
}
