// Rows of the table of models: which models are left out and which errors end the fit, and tables of small numbers.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/error.h"
#include "analysis/models/mpi.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/runs/source.h"
#include "tests/bench/cli/play_table.h"
#include "tests/support/process.h"

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

// One taxel whose errors are known: of the direct model, compensated, and of a straight line.
ModelRow row_with(const std::string& label, double direct, double compensated, double raw) {
  ModelRow row;
  row.label = label;
  row.document.model = label;
  analysis::ModelTaxel& taxel = row.document.taxels.emplace_back();
  taxel.status = analysis::TaxelStatus::kFitted;
  taxel.fit.model =
      std::make_unique<analysis::MpiModel>(analysis::MpiParameters{0.1, 0.0, 0.0, 3.0, 0.5}, 0.0, 60.0, 0.0);
  taxel.fit.j = 2.5;
  taxel.fit.mean_error = direct;
  taxel.fit.max_error = 2.0 * direct;
  taxel.fit.full_scale = 2.0;
  analysis::ModelScore& score = row.scores.emplace_back();
  score.count = 1;
  score.full_scale = 2.0;
  score.taxels.direct = {direct, 2.0 * direct, 1};
  score.taxels.free_running = {3.0 * direct, 4.0 * direct, 1};
  score.taxels.compensated = {compensated, 2.0 * compensated, 1};
  score.taxels.raw = {raw, 2.0 * raw, 1};
  return row;
}

std::string scores_of(std::vector<ModelRow>& rows, const std::string& unit, analysis::PressureUnit shown) {
  analysis::Histories histories;
  histories.taxels.emplace_back().score.push_back({"up", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.0}, {}});
  return scores_table(rows, {{"it", &histories, {}}}, unit, shown);
}

}  // namespace

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
  CHECK_THAT(refusals[0].why, Catch::Contains(" nonsense cannot be fitted: "));
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

TEST_CASE("tables of models: a search may miss the least, one sample is a cross-validation, and none is not") {
  std::vector<ModelRow> rows;
  rows.push_back(row_with("gpi", 0.02, 1.0, 2.0));
  rows.push_back(row_with("mpi", 0.02, 1.0, 2.0));
  rows[0].crossed = {0.5, 0.5, 1};
  rows[1].document.taxels[0].fit.undetermined = {"tau"};
  CHECK(fits_table(rows) ==
        "model                 params            J  mean %FS  max %FS  cross %FS  ops/smpl  taxels\n"
        "gpi                        5          2.5     1.000    2.000     25.000        56       1\n"
        "mpi                        5          2.5     1.000    2.000          -        56       1\n"
        "gpi: found by a search, which may miss the least J; the others are exact\n"
        "mpi: the data do not determine tau (1 of 1 taxel)\n");
}

TEST_CASE("tables of models: decimals by the size of the errors, powers of ten below seven of them, and kPa") {
  const auto line_of_none = [](double raw, analysis::PressureUnit shown = analysis::PressureUnit::kPsi) {
    std::vector<ModelRow> rows;
    rows.push_back(row_with("mpi", 0.02, 0.25 * raw, raw));
    const std::string text = scores_of(rows, "psi", shown),
                      head = "\nnone (straight line)            -         -          -         -";
    const std::size_t at = text.find(head) + head.size();
    return text.substr(at, text.find('\n', at) - at);
  };
  CHECK(line_of_none(20.0) == "      20.000      40.000");
  CHECK(line_of_none(1.0) == "       1.000       2.000");
  CHECK(line_of_none(0.5) == "      0.5000      1.0000");
  CHECK(line_of_none(0.02) == "     0.02000     0.04000");
  CHECK(line_of_none(0.0002) == "   0.0002000   0.0004000");
  CHECK(line_of_none(0.00002) == "    2.00e-05    4.00e-05");
  CHECK(line_of_none(0.0) == "       0.000       0.000");
  CHECK(line_of_none(1.0, analysis::PressureUnit::kKilopascal) == "       6.895      13.790");
  CHECK(line_of_none(0.00002, analysis::PressureUnit::kKilopascal) == "   0.0001379   0.0002758");
  CHECK(line_of_none(0.00001, analysis::PressureUnit::kKilopascal) == "    6.89e-05    1.38e-04");
}

TEST_CASE("tables of models: bins of rates in the unit shown, and of a model that has fewer of them") {
  std::vector<ModelRow> rows;
  rows.push_back(row_with("mpi", 0.02, 1.0, 2.0));
  rows.push_back(row_with("a longer label", 0.02, 1.0, 2.0));
  rows[0].scores[0].taxels.by_rate = {{1.0, 2.0, {1.0, 0.5, 2}}, {2.0, 4.0, {3.0, 1.5, 3}}};
  rows[1].scores[0].taxels.by_rate = {{1.0, 2.0, {0.5, 0.5, 2}}};
  const std::string psi = scores_of(rows, "psi", analysis::PressureUnit::kPsi);
  CHECK_THAT(psi, Catch::EndsWith("\n\n  by rate, mean compensation error by model\n"
                                  "               psi/s   samples         mpi  a longer label\n"
                                  "              1 .. 2         2       0.500           0.250\n"
                                  "              2 .. 4         3       1.000           0.000\n"));
  CHECK_THAT(scores_of(rows, "psi", analysis::PressureUnit::kKilopascal),
             Catch::EndsWith("\n               kPa/s   samples         mpi  a longer label\n"
                             "      6.895 .. 13.79         2       3.447           1.724\n"
                             "      13.79 .. 27.58         3       6.895           0.000\n"));
  CHECK(psi.find("by hold time") == std::string::npos);
  rows[0].scores[0].taxels.by_rate.pop_back();
  CHECK(scores_of(rows, "psi", analysis::PressureUnit::kPsi).find("by rate") == std::string::npos);
  rows[0].scores[0].taxels.raw = {0.000001, 0.000001, 1};  // decimals of bins are seven at most
  rows[0].scores[0].taxels.by_hold = {{1.0, 2.0, {1.0, 0.5, 2}}, {2.0, 4.0, {3.0, 1.5, 3}}};
  CHECK_THAT(scores_of(rows, "psi", analysis::PressureUnit::kKilopascal),
             Catch::Contains("\n              1 .. 2         2   3.4473786"));
}
