// Models on any table, as a person uses them: exit codes, files.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/bench/cli/check_refusal.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Sequences "full" (two cycles) and "inner".
std::string table(double sign = 1.0) {
  std::string text = "sequence,step,input,output\n";
  const auto add = [&](const std::string& name, const std::vector<double>& turns) {
    for (const PlaySample& sample : play_samples(turns))
      text += name + "," + std::to_string(sample.step) + "," + std::to_string(sample.input) + "," +
              std::to_string(sign * sample.output) + "\n";
  };
  add("full", {0, 10, 0, 10, 5, 10, 0});
  add("inner", {0, 8, 2, 6, 3, 10, 0});
  return text;
}

std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    auto& row = rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
  }
  return rows;
}

}  // namespace

TEST_CASE("all models are fitted on one sequence of a table and scored on the other") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  const json document = json::parse(well(call(folder, {"compare", "t.csv", "--fit", "full", "--json"})).out);
  REQUIRE(document["models"].size() == 6);
  CHECK(document["origin"] == "imported");
  double monotone = 0.0, preisach = 0.0;
  for (const json& model : document["models"]) {
    const json& score = model["scores"][0];
    CHECK(score["on"] == "inner of t.csv");
    CHECK(score["all"]["direct"]["samples"] == 240);
    CHECK(model["shown_taxel"]["parameters"].size() > 1);
    (model["model"] == "monotone" ? monotone : preisach) = score["all"]["compensated"]["mean"];
    if (model["model"] == "preisach") break;
  }
}

TEST_CASE("a stored model predicts and compensates in a pipe, full precision in and out") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "preisach", "-o", "m.json"}).code == 0);
  const Finished predicted = call(folder, {"predict", "m.json", "t.csv"});
  INFO(predicted.err);
  REQUIRE(predicted.code == 0);
  const auto rows = rows_of(predicted.out);
  REQUIRE(rows.size() == 483);
  CHECK(rows[0].back() == "predicted");
  double worst = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    worst = std::max(worst, std::abs(std::stod(rows[i][4]) - std::stod(rows[i][3])));
  CHECK(worst < 0.6);
  // What is predicted is compensated back to the very inputs.
  REQUIRE(call(folder, {"predict", "m.json", "t.csv", "-o", "p.csv"}).code == 0);
  CHECK(read_file(folder.path("p.csv")) == predicted.out);
  const Finished back = call(folder, {"compensate", "m.json", "p.csv", "--map", "output=predicted"});
  const auto inputs = rows_of(back.out);
  REQUIRE(inputs.size() == 483);
  int near = 0;
  for (std::size_t i = 1; i < inputs.size(); ++i)
    near += std::abs(std::stod(inputs[i][5]) - std::stod(inputs[i][2])) < 0.3 ? 1 : 0;
  CHECK(near > 440);
}

TEST_CASE("a falling sensor is fitted and predicted with its own sign") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table(-1.0));
  REQUIRE(call(folder, {"fit", "t.csv", "-o", "m.json"}).code == 0);
  const auto rows = rows_of(call(folder, {"predict", "m.json", "t.csv"}).out);
  REQUIRE(rows.size() == 483);
  CHECK(std::stod(rows[40][4]) < -5.0);
  CHECK(std::stod(rows[40][4]) == Approx(std::stod(rows[40][3])).margin(0.3));
}

TEST_CASE("bad tables and models are refused with fault, place and remedy") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  write_file(folder.path("nan.csv"), "input,output\n1,2\n2,nan\n");
  write_file(folder.path("ragged.csv"), "input,output\n1,2\n2\n");
  write_file(folder.path("empty.csv"), "");
  write_file(folder.path("constant.csv"), "input,output\n1,2\n1,3\n1,4\n1,5\n");
  write_file(folder.path("up.csv"), "input,output\n0,0\n1,1\n2,2\n3,3\n4,4\n");
  well(call(folder, {"fit", "t.csv", "-o", "m.json"}));
  well(call(folder, {"fit", "up.csv", "--model", "monotone"}));
  struct RefusedTable {
    const char* words;
    int code;
    const char* id;
  };
  for (const auto& [words, code, id] :
       {RefusedTable{"fit nan.csv", 2, "TB-TABLE-ROW"}, RefusedTable{"fit ragged.csv", 2, "TB-TABLE-ROW"},
        RefusedTable{"fit empty.csv", 2, "TB-TABLE-EMPTY"}, RefusedTable{"fit missing.csv", 2, "TB-TABLE-OPEN"},
        RefusedTable{"fit constant.csv", 2, "TB-TABLE-CONSTANT"}, RefusedTable{"fit up.csv", 6, "TB-ANALYSIS-NO-LOOP"},
        RefusedTable{"fit up.csv --model preisach", 6, "TB-ANALYSIS-MODEL"},
        RefusedTable{"runs import nan.csv", 2, "TB-TABLE-ROW"}, RefusedTable{"fit t.csv --model duhem", 2, "TB-USAGE"},
        RefusedTable{"fit t.csv --fit sideways", 2, "TB-MODEL-SEQUENCE"},
        RefusedTable{"predict t.csv t.csv", 2, "TB-MODEL-DOCUMENT"},
        RefusedTable{"predict none.json t.csv", 2, "TB-MODEL-OPEN"},
        RefusedTable{"predict /dev/zero t.csv", 2, "TB-MODEL-OPEN"},
        RefusedTable{"model show /proc/self/mem", 2, "TB-MODEL-DOCUMENT"},  // says it is empty
        RefusedTable{"fit /dev/zero", 2, "TB-TABLE-OPEN"},
        RefusedTable{"predict m.json up.csv --map input=x", 2, "TB-TABLE-COLUMN"},
        RefusedTable{"compensate m.json t.csv --taxel 7", 2, "TB-MODEL-TAXEL"}}) {
    INFO(words);
    std::istringstream stream(words);
    check_refusal(call(folder, {std::istream_iterator<std::string>(stream), {}}), code, id);
  }
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db")));
}
