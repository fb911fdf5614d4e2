// model diff of models of two tables whose differences are known.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/check_refusal.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Taxel t has 1 + t / 10 times the play's outputs, and its own zero.
std::string table_of_taxels(const std::vector<double>& zeros) {
  std::string text = "taxel,input,output\n";
  for (std::size_t t = 0; t < zeros.size(); ++t)
    for (const PlaySample& sample : play_samples({0, 10, 0, 10, 5, 10, 0}))
      text += std::to_string(t) + "," + std::to_string(sample.input) + "," +
              std::to_string(zeros[t] + (1.0 + 0.1 * static_cast<double>(t)) * sample.output) + "\n";
  return text;
}

struct TwoModels {
  TwoModels() {
    write_file(folder.path("a.csv"), table_of_taxels({0, 0, 0}));
    write_file(folder.path("b.csv"), table_of_taxels({0.5, 1.0}));
    for (const char* one : {"a", "b"})
      REQUIRE(call(folder,
                   {"fit", path(one, ".csv"), "--model", "poly", "-q", "--input-unit", "psi", "-o", path(one, ".json")})
                  .code == 0);
  }
  std::string path(const std::string& name, const std::string& end = ".json") const { return folder.path(name + end); }
  Finished diff(const std::string& first, const std::string& second, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"model", "diff", path(first), path(second)});
    return call(folder, more);
  }
  std::map<std::string, nlohmann::json> parameters(const std::vector<std::string>& more) const {
    std::map<std::string, nlohmann::json> found;
    const auto told = nlohmann::json::parse(diff("a", "b", more).out);
    for (const auto& one : told.at("parameters")) found[one.at("name").get<std::string>()] = one;
    return found;
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("model diff: parameters of powers of the input are told in the unit of pressure that is asked for") {
  const TwoModels models;
  const auto psi = models.parameters({"--json"}), kpa = models.parameters({"--json", "--units", "kPa"});
  constexpr double kKilopascals = 6.894757293168361;
  for (int power = 1; power <= 6; ++power) {
    const std::string name = "a" + std::to_string(6 - power);
    const std::string unit = power == 1 ? "" : "^" + std::to_string(power);
    CHECK(psi.at(name).at("unit") == "y/psi" + unit);
    CHECK(kpa.at(name).at("unit") == "y/kPa" + unit);
    for (const char* figure : {"mean", "largest"})
      CHECK(kpa.at(name).at(figure).get<double>() * std::pow(kKilopascals, power) ==
            Approx(psi.at(name).at(figure).get<double>()).epsilon(1e-9));
  }
}

TEST_CASE("model diff: a model is the same as itself, and two kinds are not compared") {
  const TwoModels models;
  CHECK(models.diff("a", "a").code == 0);
  CHECK(nlohmann::json::parse(models.diff("b", "b", {"--json"}).out).at("same") == true);
  REQUIRE(call(models.folder, {"fit", models.path("a", ".csv"), "--model", "monotone", "-q", "-o", models.path("c")})
              .code == 0);
  check_refusal(models.diff("a", "c"), 2, "TB-MODEL-DIFF", "model diff");
}
