// The rows of models: which are left out and which errors end the fit, and what a row tells as JSON.
#include "bench/cli/models/model_table.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "analysis/error.h"
#include "analysis/report/document/printers.h"
#include "analysis/text_width.h"
#include "bench/cli/runs/source.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench;
using namespace tactbench::tests;
using namespace tactbench::bench;

namespace {

analysis::Histories histories_of(const std::vector<double>& turns) {
  const TemporaryFolder folder;
  std::string text = "input,output\n";
  for (const PlaySample& sample : play_samples(turns))
    text += std::to_string(sample.input) + "," + std::to_string(sample.output) + "\n";
  write_file(folder.path("t.csv"), text);
  Session session;
  session.quiet = true;
  return read_source(folder.path("t.csv"), {}, session);
}

analysis::ModelTaxel fitted_taxel(int number) {
  analysis::ModelTaxel taxel = taxel_with(number, {0.1, 0.0, 0.0, 3.0, 5.0});
  taxel.fit.samples = 7;
  taxel.fit.starts = 3;
  return taxel;
}

// What the models are scored on: tables ask it for its validity alone.
analysis::Histories one_taxel() {
  analysis::Histories histories;
  analysis::TaxelHistories& taxel = histories.taxels.emplace_back();
  taxel.score.push_back({"up", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.0}, {}});
  taxel.fit = taxel.score;
  return histories;
}

// Taxels 0 and 2, a dead one between them, and the mean taxel.
ModelRow row_of_array() {
  ModelRow row;
  row.label = "mpi";
  row.crossed = {0.5, 0.3, 5};
  row.document.model = "mpi";
  row.document.taxels.push_back(fitted_taxel(0));
  row.document.taxels.emplace_back();
  row.document.taxels.back().status = analysis::TaxelStatus::kDead;
  row.document.taxels.push_back(fitted_taxel(2));
  row.document.taxels.push_back(fitted_taxel(analysis::kMeanTaxel));
  analysis::ModelScore score;
  score.count = 2;
  score.full_scale = 2.0;
  score.taxels.direct = {0.3, 0.2, 6};
  score.taxels.free_running = {0.6, 0.3, 6};
  score.taxels.compensated = {3.0, 1.5, 6};
  score.taxels.raw = {6.0, 2.25, 6};
  score.taxels.by_hold = {{0.1, 1.0, {1.0, 0.5, 2}}, {1.0, 10.0, {2.0, 1.5, 4}}};
  score.taxels.by_rate = {{1.0, 2.0, {1.0, 0.5, 2}}};
  score.mean.compensated = {0.6, 0.4, 3};
  score.mean.raw = {1.5, 0.75, 3};
  row.scores.push_back(score);
  return row;
}

}  // namespace

TEST_CASE("a row of models as JSON: the shown taxel, its parameters and its scores") {
  const analysis::Histories histories = one_taxel();
  const nlohmann::ordered_json row = model_row_json(row_of_array(), {{"run 2", &histories, {}}});
  CHECK(row["model"] == "mpi");
  CHECK(row["fit"] == 0);
  const auto& shown = row["shown_taxel"];
  check_members(shown, R"({"taxel": -1, "j": 2.5, "samples": 7, "starts": 3, "operations_per_sample": 56})");
  CHECK(shown["cross_validated"]["mean"].get<double>() == Approx(0.1));
  CHECK(shown["cross_validated"]["max"] == 0.3);
  REQUIRE(shown["parameters"].size() == 5);
  CHECK(shown["parameters"][4]["name"] == "tau");
  CHECK(shown["parameters"][4]["at_bound"] == true);
  CHECK(shown["parameters"][3]["at_bound"] == false);
  const auto& score = row["scores"][0];
  check_members(score, R"({"on": "run 2", "taxels": 2, "full_scale": 2.0})");
  CHECK(score["all"]["direct"]["mean"].get<double>() == Approx(0.05));
  CHECK(score["all"]["free_running"]["mean"].get<double>() == Approx(0.1));
  CHECK(score["all"]["free_running"]["max"] == 0.3);
  CHECK(score["outside_validity"].empty());
  CHECK(score["all"]["by_hold_s"][1]["low"] == 1.0);
  CHECK(score["all"]["by_hold_s"][1]["compensated"]["mean"] == 0.5);
  CHECK(score["mean_taxel"]["raw"]["max"] == 0.75);
  ModelRow alone = row_of_array();
  alone.crossed = {};
  CHECK_FALSE(model_row_json(alone, {{"run 2", &histories, {}}})["shown_taxel"].contains("cross_validated"));
}

TEST_CASE("rows of models: what the data cannot carry is left out as long as another model is there, no other error") {
  const analysis::Histories loops = histories_of({0, 10, 0, 10, 5, 10, 0});
  std::vector<ModelRefusal> refusals;
  std::vector<std::string> begun;
  const auto begin = [&](const std::string& model) { begun.push_back(model); };
  const std::vector<ModelRow> rows = model_rows({"nonsense", "monotone"}, loops, {}, {}, {}, &refusals, begin);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].label == "monotone");
  CHECK_FALSE(rows[0].document.program_version.empty());
  REQUIRE(refusals.size() == 1);
  CHECK(refusals[0].model == "nonsense");
  CHECK(begun == std::vector<std::string>{"nonsense", "monotone"});
  const auto id = [&](const std::vector<std::string>& models, const std::vector<std::string>& sequences,
                      std::vector<ModelRefusal>* left_out) -> std::string {
    try {
      (void)model_rows(models, loops, sequences, {}, {}, left_out);
    } catch (const analysis::AnalysisError& error) {
      return error.id();
    }
    return "";
  };
  CHECK(id({"monotone", "nonsense"}, {}, &refusals).empty());  // the last, and there is a row
  CHECK(id({"nonsense"}, {}, &refusals) == "TB-ANALYSIS-MODEL");
  CHECK(id({"nonsense", "monotone"}, {}, nullptr) == "TB-ANALYSIS-MODEL");
  const std::string other = id({"monotone", "poly"}, {"none"}, &refusals);
  CHECK_FALSE(other.empty());
  CHECK((other != "TB-ANALYSIS-MODEL" && other != "TB-ANALYSIS-NO-LOOP"));
}

TEST_CASE("tables of models keep to the terminal, however large their numbers are") {
  const analysis::Histories histories = one_taxel();
  for (const double factor : {1.0, 1e3, 1e20, 1e300}) {
    ModelRow row = row_of_array();
    analysis::ModelScore& score = row.scores.front();
    for (analysis::ErrorSum* error : {&score.taxels.direct, &score.taxels.free_running, &score.taxels.compensated,
                                      &score.mean.compensated, &row.crossed}) {
      error->sum *= factor;
      error->max *= factor;
    }
    analysis::doc::Document out = fits_document({row}, true);
    out.add(scores_document({row}, {{"run 2", &histories, {}}}, "N", {}, true));
    for (const std::size_t width : {80U, 120U}) {
      std::istringstream lines(to_text(out, {}, width));
      for (std::string line; std::getline(lines, line);) CHECK(analysis::display_width(line) <= width);
    }
  }
}
