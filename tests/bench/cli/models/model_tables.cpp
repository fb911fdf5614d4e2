// The tables of models, of rows that are known number by number.
#include "bench/cli/models/model_table.h"

#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/models/mpi.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

analysis::ModelTaxel fitted_taxel(int number) {
  analysis::ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = analysis::TaxelStatus::kFitted;
  taxel.fit.model =
      std::make_unique<analysis::MpiModel>(analysis::MpiParameters{0.1, 0.0, 0.0, 3.0, 5.0}, 0.0, 60.0, 0.0);
  taxel.fit.j = 2.5;
  taxel.fit.mean_error = 0.02;
  taxel.fit.max_error = 0.06;
  taxel.fit.full_scale = 2.0;
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

ModelRow row_of_one(const std::string& label) {
  ModelRow row;
  row.label = label;
  row.document.model = "mpi";
  row.document.taxels.push_back(fitted_taxel(0));
  analysis::ModelScore score;
  score.count = 1;
  score.full_scale = 2.0;
  score.taxels.direct = {0.1, 0.1, 1};
  score.taxels.free_running = {0.15, 0.15, 1};
  score.taxels.compensated = {0.25, 0.25, 1};
  score.taxels.raw = {0.5, 0.5, 1};
  score.taxels.by_rate = {{1.0, 2.0, {0.25, 0.25, 1}}, {2.0, 4.0, {}}};
  row.scores.push_back(score);
  return row;
}

}  // namespace

TEST_CASE("table of fits: the mean taxel of an array, the only one of others, cross-validation where there was any") {
  std::vector<ModelRow> rows;
  rows.push_back(row_of_array());
  rows.push_back(row_of_one("mpi, alone"));
  CHECK(fits_table(rows) ==
        "model                 params            J  mean %FS  max %FS  cross %FS  ops/smpl  taxels\n"
        "mpi                        5          2.5     1.000    3.000      5.000        56       2\n"
        "mpi, alone                 5          2.5     1.000    3.000          -        56       1\n");
}

TEST_CASE("table of scores: an array beside a straight line, its mean taxel, and what depends on the hold") {
  const analysis::Histories histories = one_taxel();
  std::vector<ModelRow> rows;
  rows.push_back(row_of_array());
  CHECK(scores_table(rows, {{"run 2", &histories, {}}}, "psi") ==
        "\n"
        "scored on run 2 (6 samples, 2 taxels)\n"
        "                                              direct model, % FS\n"
        "                        from measured turns         free running        compensated, psi      mean taxel\n"
        "model                        mean       max       mean       max        mean         max      mean       max\n"
        "none (straight line)            -         -          -         -       1.000       2.250     0.500     0.750\n"
        "mpi                         2.500    10.000      5.000    15.000       0.500       1.500     0.200     0.400\n"
        "\n"
        "  by hold time, mean compensation error by model\n"
        "                   s   samples         mpi\n"
        "            0.1 .. 1         2       0.500\n"
        "             1 .. 10         4       0.500\n");
  rows.clear();
  rows.push_back(row_of_one("a very long name"));
  CHECK(scores_table(rows, {{"table", &histories, {}}}, "N") ==
        "\n"
        "scored on table (1 sample)\n"
        "                                              direct model, % FS\n"
        "                        from measured turns         free running          compensated, N\n"
        "model                        mean       max       mean       max        mean         max\n"
        "none (straight line)            -         -          -         -      0.5000      0.5000\n"
        "a very long name            5.000     5.000      7.500     7.500      0.2500      0.2500\n"
        "\n"
        "  by rate, mean compensation error by model\n"
        "                 N/s   samples  a very long name\n"
        "              1 .. 2         1            0.2500\n"
        "              2 .. 4         0            0.0000\n");
}

TEST_CASE("a row of models as JSON: the shown taxel, its parameters and its scores") {
  const analysis::Histories histories = one_taxel();
  const nlohmann::ordered_json row = model_row_json(row_of_array(), {{"run 2", &histories, {}}});
  CHECK(row["model"] == "mpi");
  CHECK(row["fit"] == 0);
  const auto& shown = row["shown_taxel"];
  CHECK(shown["taxel"] == -1);
  CHECK(shown["j"] == 2.5);
  CHECK(shown["samples"] == 7);
  CHECK(shown["starts"] == 3);
  CHECK(shown["operations_per_sample"] == 56);
  CHECK(shown["cross_validated"]["mean"].get<double>() == Approx(0.1));
  CHECK(shown["cross_validated"]["max"] == 0.3);
  REQUIRE(shown["parameters"].size() == 5);
  CHECK(shown["parameters"][4]["name"] == "tau");
  CHECK(shown["parameters"][4]["at_bound"] == true);
  CHECK(shown["parameters"][3]["at_bound"] == false);
  const auto& score = row["scores"][0];
  CHECK(score["on"] == "run 2");
  CHECK(score["taxels"] == 2);
  CHECK(score["full_scale"] == 2.0);
  CHECK(score["all"]["direct"]["mean"].get<double>() == Approx(0.05));
  CHECK(score["all"]["free_running"]["mean"].get<double>() == Approx(0.1));
  CHECK(score["all"]["free_running"]["max"] == 0.3);
  CHECK(score["outside_validity"].empty());
  CHECK(score["all"]["by_hold_s"][1]["low"] == 1.0);
  CHECK(score["all"]["by_hold_s"][1]["compensated"]["mean"] == 0.5);
  CHECK(score["mean_taxel"]["raw"]["max"] == 0.75);
  const nlohmann::ordered_json alone = model_row_json(row_of_one("alone"), {{"table", &histories, {}}});
  CHECK_FALSE(alone["shown_taxel"].contains("cross_validated"));
  CHECK(alone["shown_taxel"].contains("parameters"));
}

TEST_CASE("what the data leave open: counted over the taxels of an array without its mean, or over the mean alone") {
  ModelRow row = row_of_array();
  CHECK(undetermined_text(row.document).empty());
  row.document.taxels[0].fit.undetermined = {"tau"};
  row.document.taxels[2].fit.undetermined = {"tau", "q"};
  row.document.taxels[3].fit.undetermined = {"tau", "q"};
  CHECK(undetermined_text(row.document) == "mpi: the data do not determine tau, q (2 of 3 taxels)\n");
  row.document.taxels.erase(row.document.taxels.begin(), row.document.taxels.begin() + 3);
  CHECK(undetermined_text(row.document) == "mpi: the data do not determine tau, q (1 of 1 taxel)\n");
}
