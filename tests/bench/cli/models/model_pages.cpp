// What `model show` and `model diff` print of models that are known number by number.
#include <catch2/catch.hpp>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/mpi.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/models/models_here.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("model show: what was fitted, where it holds, and the last taxel's numbers") {
  const TemporaryFolder folder;
  write_model(folder, "m.json", known_model(0.1, 0.0));
  SensorModel document = analysis::load_model(folder.path("m.json"), nullptr);
  check_holds(
      model_verb(folder, {"model", "show", "m.json"}),
      {"mpi of me.csv (imported), sha256 " + analysis::sha256_of(document).substr(0, 12), "  fitted on     up, down",
       "  content       0123", "  sensor        S-1, scanner (not stated)", "  units         N to V",
       "  valid for     input 0 .. 60 N; hold not known; rate 0.5 .. 2 N/s; temperature not known",
       "  mount         glued", "  interface     not stated", "  taxels        1 dead, 2 fitted; and the mean taxel",
       "mean taxel: J 2.5, mean error 1.000 % FS, max 3.000 % FS, full scale 2 V, noise 0.004 V",
       "  a1            0.1                   V/N", "  tau           5                     1  at its bound"});
  document.taxels.resize(1);
  document.parent_sha256 = "00112233445566";
  document.adjustment = "zero by t.csv";
  document.falling = true;
  write_model(folder, "one.json", document);
  check_holds(
      model_verb(folder, {"model", "show", "one.json"}),
      {"  units         N to V, falling", "  parent        001122334455: zero by t.csv", "  taxels        1 fitted",
       "taxel 0: J 2.5, mean error 1.000 % FS, max 3.000 % FS, full scale 2 V, noise 0.004 V",
       "  tau           0.7                   1"});
}

TEST_CASE("model diff: mean and largest difference of each parameter, with sign and taxel") {
  const TemporaryFolder folder;
  write_model(folder, "m.json", known_model(0.1, 0.0));
  write_model(folder, "n.json", known_model(0.04, 0.25));
  const Finished differ = model_verb(folder, {"model", "diff", "m.json", "n.json"});
  CHECK(differ.code == 1);
  check_holds(differ,
              {"n.json against m.json: not the same", "parameter            mean diff       largest   taxel  unit",
               "zero                 0.0833333          0.25       2  V",
               "gain                         0             0       0  1",
               "a1                       -0.02         -0.06       2  V/N",
               "tau                          0             0       0  1"});
  CHECK(differ.out.find("fitted in the first alone") == std::string::npos);
  const nlohmann::json told =
      nlohmann::json::parse(model_verb(folder, {"model", "diff", "m.json", "n.json", "--json"}).out);
  CHECK(told["same"] == false);
  CHECK(told["taxels_of_first_alone"] == 0);
  REQUIRE(told["parameters"].size() == 7);
  CHECK(told["parameters"][2]["name"] == "a1");
  CHECK(told["parameters"][2]["largest"].get<double>() == Approx(-0.06));
  CHECK(told["parameters"][2]["mean"].get<double>() == Approx(-0.02));
  CHECK(told["parameters"][2]["taxel"] == 2);
  SensorModel fewer = known_model(0.1, 0.0);
  fewer.taxels.erase(fewer.taxels.begin() + 2);
  write_model(folder, "fewer.json", fewer);
  check_holds(model_verb(folder, {"model", "diff", "m.json", "fewer.json"}), {"1 taxel is fitted in the first alone"});
  check_holds(model_verb(folder, {"model", "diff", "fewer.json", "fewer.json"}),
              {"fewer.json against fewer.json: the same, byte for byte"});
}

TEST_CASE("model show and diff in kPa: ranges and parameters of pressures, and no others") {
  const TemporaryFolder folder;
  constexpr double kKpaPerPsi = 6.894757293168361;
  SensorModel document = known_model(0.1, 0.0), other = known_model(0.04, 0.25);
  for (SensorModel* model : {&document, &other}) model->input_unit = "psi";
  write_model(folder, "m.json", document);
  write_model(folder, "n.json", other);
  write_model(folder, "newtons.json", known_model(0.1, 0.0));
  const auto number_behind = [](const std::string& text, const std::string& name) {
    const std::size_t at = text.find("\n" + name);
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + 1 + name.size()));
  };
  const Finished shown = model_verb(folder, {"model", "show", "m.json", "--units", "kPa"});
  CHECK_THAT(shown.out, Catch::Contains("input 0 .. 413.7 kPa; hold not known; rate 3.447 .. 13.79 kPa/s;") &&
                            Catch::Contains(" V/kPa\n") && Catch::Contains(" V/kPa^2\n"));
  CHECK(number_behind(shown.out, "  a1") == Approx(0.1 / kKpaPerPsi));
  CHECK(number_behind(shown.out, "  a2") == Approx(-0.001 / (kKpaPerPsi * kKpaPerPsi)));
  CHECK(number_behind(shown.out, "  rho") == Approx(3.0));
  CHECK(model_verb(folder, {"model", "show", "newtons.json", "--units", "kPa"}).out ==
        model_verb(folder, {"model", "show", "newtons.json"}).out);
  const Finished differ = model_verb(folder, {"model", "diff", "m.json", "n.json", "--units", "kPa"});
  CHECK(number_behind(differ.out, "a1") == Approx(-0.02 / kKpaPerPsi).epsilon(1e-5));
  CHECK(number_behind(differ.out, "zero") == Approx(0.25 / 3.0).epsilon(1e-5));
}

TEST_CASE("model diff: parameters of inputs in different units are not compared, and that is said") {
  const TemporaryFolder folder;
  SensorModel pressures = known_model(0.04, 0.25);
  pressures.input_unit = "psi";
  write_model(folder, "psi.json", pressures);
  write_model(folder, "n.json", known_model(0.1, 0.0));
  check_holds(
      model_verb(folder, {"model", "diff", "n.json", "psi.json"}),
      {"a1                           -             -       -  not compared: V/N in the first, V/psi in the second",
       "tau                          0             0       0  1"});
  const nlohmann::json told =
      nlohmann::json::parse(model_verb(folder, {"model", "diff", "n.json", "psi.json", "--json"}).out);
  CHECK((told["parameters"][2]["unit"] == "V/N" && told["parameters"][2]["unit_of_second"] == "V/psi"));
  CHECK((told["parameters"][2]["mean"].is_null() && told["parameters"][2]["largest"].is_null()));
  CHECK(told["parameters"][0]["mean"].get<double>() == Approx(0.25 / 3.0));
}

TEST_CASE("predict and compensate along a table: taxel by taxel, with zero and gain, reporting values outside") {
  const TemporaryFolder folder;
  SensorModel document = known_model(0.1, 0.0);
  document.validity.input = analysis::Range{0.0, 64.0};
  document.taxels.pop_back();
  for (ModelTaxel& taxel : document.taxels) {
    if (taxel.taxel == 1) continue;
    // A straight line, 0.125 V/N: no play rubs.
    taxel.fit.model =
        std::make_unique<analysis::MpiModel>(analysis::MpiParameters{0.125, 0.0, 0.0, 0.0, 0.7}, 0.0, 64.0, 0.0);
    taxel.fit.full_scale = 8.0;
    taxel.noise = 0.0;
  }
  document.taxels.back().zero = 0.5;
  document.taxels.back().gain = 2.0;
  write_model(folder, "line.json", document);
  write_file(folder.path("t.csv"), "taxel,input\n0,8\n2,8\n0,16\n2,65\n0,65.5\n");
  const Finished predicted = model_verb(folder, {"predict", "line.json", "t.csv"});
  CHECK(predicted.code == 0);
  INFO(predicted.out << predicted.err);
  CHECK_THAT(predicted.out, Catch::StartsWith("taxel,input,predicted\n0,8,1\n2,8,2.5\n0,16,2\n2,65,"));
  CHECK_THAT(predicted.err, Catch::Contains("1 of 5 inputs lie outside the model's validity, 0 to 64 N"));
  document.input_unit = "psi";
  write_model(folder, "psi.json", document);
  const Finished in_kpa = model_verb(folder, {"predict", "psi.json", "t.csv", "--units", "kPa"});
  CHECK(in_kpa.out == predicted.out);
  CHECK_THAT(in_kpa.err, Catch::Contains("1 of 5 inputs lie outside the model's validity, 0 to 441.3 kPa"));
  write_file(folder.path("y.csv"), "taxel;output\n0;1\n2;2.5\n0;8.5\n2;-1\n0;0.5\n");
  const Finished back = model_verb(folder, {"compensate", "line.json", "y.csv"});
  CHECK(back.code == 0);
  INFO(back.out << back.err);
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(back.out);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string>& row = rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ';');) row.push_back(cell);
  }
  REQUIRE(rows.size() == 6);
  CHECK(rows[0] == std::vector<std::string>{"taxel", "output", "compensated", "uncertainty", "flags"});
  for (const auto& [row, input] : {std::pair{1U, 8.0}, {2U, 8.0}, {5U, 4.0}}) {
    REQUIRE(rows[row].size() == 4);  // no flag
    CHECK(std::stod(rows[row][2]) == Approx(input));
    CHECK(rows[row][3] == "nan");  // the noise is not known
  }
  for (const std::size_t row : {3U, 4U}) CHECK(rows[row].back() == "range");
  for (const auto& [more, code] : {std::pair{"0", 0}, {"2", 0}, {"1", 6}, {"7", 2}}) {
    write_file(folder.path("x.csv"), "input\n8\n");
    CHECK(model_verb(folder, {"predict", "line.json", "x.csv", "--taxel", more}).code == code);
  }
  CHECK_THAT(model_verb(folder, {"predict", "line.json", "x.csv"}).err, Catch::Contains("the model has 3 taxels"));
}
