// The dynamic model of a table with times: recordings of one taxel of the simulated film, which creeps and lags.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/simulation/specimen.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using Turns = std::vector<double>;

// A recording every 0.2 s: 4 psi per second from turn to turn, rests of 3 s at each.
std::string recorded(bool harsh, const Turns& turns, unsigned seed, double sign = 1.0, double factor = 1.0) {
  constexpr double kStep = 0.2, kRate = 4.0, kRest = 3.0;
  constexpr std::size_t kTaxel = 119;
  bench::SpecimenOptions options;
  options.sensor_seed = 7;
  if (harsh) options.kind = bench::SpecimenKind::kHarsh;
  bench::Specimen specimen(options);
  std::vector<double> volts(256);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.002), of_input(0.0, 0.01);
  std::string text = "time_s,input,output\n";
  double time_s = 0.0, psi = turns.front();
  const auto sample = [&] {
    specimen.advance(psi, kStep, {});
    time_s += kStep;
    specimen.output(volts);
    text += fmt::format("{:.3f},{:.5f},{:.6f}\n", time_s, factor * (psi + of_input(random)),
                        sign * (volts[kTaxel] + noise(random)));
  };
  for (const double turn : turns) {
    for (; std::abs(turn - psi) > 1e-9; sample()) psi += std::clamp(turn - psi, -kRate * kStep, kRate * kStep);
    for (double rested = 0.0; rested < kRest; rested += kStep) sample();
  }
  return text;
}

const Turns kFitted = {0, 60, 0, 60, 10, 50, 20, 60, 30, 45, 15, 40, 5, 55, 0, 30, 10, 60, 40, 60, 0};
const Turns kScored = {0, 60, 0, 52, 13, 44, 8, 35, 24, 58, 33, 49, 18, 27, 3, 38, 0};

double mean_compensated(const nlohmann::json& fit) {
  return fit.at("models").at(0).at("scores").at(0).at("all").at("compensated").at("mean").get<double>();
}

}  // namespace

TEST_CASE(
    "fit of a table with times: the dynamic model compensates better than Preisach, for both signs of the output") {
  for (const bool harsh : {false, true}) {
    for (const auto& [sign, factor] : {std::pair(1.0, 1.0), std::pair(-1.0, 0.1)}) {
      const TemporaryFolder folder;
      write_file(folder.path("fit.csv"), recorded(harsh, kFitted, 1, sign, factor));
      write_file(folder.path("new.csv"), recorded(harsh, kScored, 2, sign, factor));
      const auto error = [&](const char* model) {
        const Finished fit = call(folder, {"fit", "fit.csv", "--model", model, "--score", "new.csv", "--json"});
        INFO(fit.err);
        REQUIRE(fit.code == 0);
        return mean_compensated(nlohmann::json::parse(fit.out)) / factor;
      };
      const double dynamic = error("dynamic"), preisach = error("preisach");
      CAPTURE(harsh, sign, dynamic, preisach);
      CHECK(dynamic < 0.9 * preisach);
    }
  }
}

TEST_CASE("fit of a table: the dynamic model needs times and an unloaded sensor, and compensate with it needs times") {
  const TemporaryFolder folder;
  const std::string table = recorded(false, kScored, 1);
  write_file(folder.path("fit.csv"), table);
  const Finished untimed = call(folder, {"fit", "fit.csv", "--model", "dynamic", "--map", "time=none"});
  CHECK(untimed.code == 2);
  CHECK_THAT(untimed.err, Catch::Contains("TB-MODEL-DYNAMIC"));
  const Finished lifted = call(folder, {"fit", "fit.csv", "--model", "dynamic", "--map", "input=time_s,output=output"});
  CHECK(lifted.code != 0);
  CHECK(call(folder, {"fit", "fit.csv", "--model", "dynamic", "-o", "m.json"}).code == 0);
  CHECK(call(folder, {"compensate", "m.json", "fit.csv"}).code == 0);
  std::string wild = table;
  wild.insert(wild.find(',', wild.find('\n', 2000)) + 1, "99999");
  write_file(folder.path("wild.csv"), wild);
  const Finished named = call(folder, {"fit", "wild.csv", "--model", "dynamic"});
  CHECK(named.code == 6);
  CHECK_THAT(named.err, Catch::Contains("TB-ANALYSIS-MODEL"));
  CHECK(call(folder, {"fit", "wild.csv", "--model", "dynamic", "--skip-bad-rows"}).code == 0);
  const Finished blind = call(folder, {"compensate", "m.json", "fit.csv", "--map", "time=none"});
  CHECK(blind.code == 2);
  CHECK_THAT(blind.err, Catch::Contains("TB-TABLE-COLUMN"));
}

// Tables as people have them, from the command line: assumptions, omissions and doubts are reported; files stay tables.

using nlohmann::json;

namespace {

const std::vector<double> kManyTurns = {0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0};

std::string play_rows(const std::vector<double>& turns, const std::string& separator = ",", bool comma = false) {
  std::string text;
  for (const PlaySample& sample : play_samples(turns)) {
    std::string row = std::to_string(sample.input) + "|" + std::to_string(sample.output);
    if (comma) std::ranges::replace(row, '.', ',');
    text += row.replace(row.find('|'), 1, separator) + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("fit of a table: decimal commas and a units row give the same fit as the plain table") {
  const TemporaryFolder folder;
  write_file(folder.path("plain.csv"), "input,output\n" + play_rows(kManyTurns));
  write_file(folder.path("comma.csv"), "\"force, N\";\"signal, V\"\n[N];[V]\n" + play_rows(kManyTurns, ";", true));
  const std::string map = "input=\"force, N\",output=\"signal, V\"";
  const Finished plain = call(folder, {"fit", "plain.csv", "--model", "preisach", "--json"});
  const Finished comma =
      call(folder, {"fit", "comma.csv", "--map", map, "--model", "preisach", "--json", "-o", "m.json"});
  INFO(comma.err);
  REQUIRE((plain.code == 0 && comma.code == 0));
  const json a = json::parse(plain.out), b = json::parse(comma.out);
  CHECK(a["models"][0]["shown_taxel"]["j"] == b["models"][0]["shown_taxel"]["j"]);
  CHECK((b["input_unit"] == "N" && b["output_unit"] == "V"));
  CHECK((a["assumed"].empty() && b["assumed"].size() == 3));
  CHECK((a["warnings"].empty() && plain.err.empty()));
  const Finished predicted = call(folder, {"predict", "m.json", "comma.csv", "--map", map});
  CHECK_THAT(predicted.out, Catch::StartsWith("\"force, N\";\"signal, V\";predicted\n[N];[V];V\n0,000000;0,000000;"));
  write_file(folder.path("p.csv"), predicted.out);
  CHECK(call(folder, {"compensate", "m.json", "p.csv", "--map", "output=predicted"}).code == 0);
}

TEST_CASE("fit of a table: bad rows end a fit with their line, --skip-bad-rows continues without them") {
  const TemporaryFolder folder;
  std::string text = "input,output\n" + play_rows(kManyTurns);
  const std::size_t third = text.find('\n', text.find('\n') + 1) + 1;
  text.insert(third, "0.3,\n");
  write_file(folder.path("t.csv"), text);
  const Finished refused = call(folder, {"fit", "t.csv"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-TABLE-ROW]") && Catch::Contains("t.csv:3"));
  const Finished fitted = call(folder, {"fit", "t.csv", "--skip-bad-rows"});
  CHECK(fitted.code == 0);
  CHECK_THAT(fitted.err, Catch::Contains("t.csv:3"));
  write_file(folder.path("none.csv"), "input,output\n1,2\n,\n,\n");
  check_refusal(call(folder, {"fit", "none.csv", "--skip-bad-rows"}), 2, "TB-TABLE-SKIPPED");
}

TEST_CASE("fit of a table: --turn sets the smallest reversal, in units of the input") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), "input,output\n" + play_rows(kManyTurns));
  const auto turn = [&](const std::vector<std::string>& more) {
    return json::parse(call(folder, joined({"fit", "t.csv", "--model", "monotone", "--json"}, more)).out)
        .at("turn")
        .get<double>();
  };
  CHECK(turn({}) == Approx(0.01).epsilon(0.1));
  CHECK(turn({"--turn", "4.5"}) == Approx(4.5));
  check_refusal(call(folder, {"fit", "t.csv", "--turn", "10"}), 2, "TB-TABLE-TURN");
}

// compensate on a recording that begins in mid-branch: said, and its uncertainty holds the truth.

namespace {

std::string rows_from(const std::vector<PlaySample>& samples, std::size_t first) {
  std::string text = "input,output\n";
  for (std::size_t i = first; i < samples.size(); ++i)
    text += std::to_string(samples[i].input) + "," + std::to_string(samples[i].output) + "\n";
  return text;
}

struct Read {
  double input = 0.0, compensated = 0.0, uncertainty = 0.0;
  std::string flags;
};

std::vector<Read> reads_of(const std::string& text) {
  REQUIRE(text.starts_with("input,output,compensated,uncertainty,flags\n"));
  auto rows = cells_of(text);
  rows.erase(rows.begin());
  std::vector<Read> reads;
  for (const auto& cells : rows)
    reads.push_back({std::stod(cells.at(0)), std::stod(cells.at(2)), std::stod(cells.at(3)), cells.at(4)});
  return reads;
}

}  // namespace

TEST_CASE("compensate: a recording that starts in mid-unloading is flagged unknown, and 2 u covers the true input") {
  const TemporaryFolder folder;
  write_file(folder.path("fitted.csv"),
             rows_from(play_samples({0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0}), 0));
  const std::vector<PlaySample> all = play_samples({0, 10, 2, 9, 0, 10, 4});
  std::size_t mid_fall = 0;  // on the way down from the first 10
  while (mid_fall == 0 || all[mid_fall].input > 6.0 || all[mid_fall].input > all[mid_fall - 1].input) ++mid_fall;
  write_file(folder.path("late.csv"), rows_from(all, mid_fall));
  write_file(folder.path("whole.csv"), rows_from(all, 0));
  for (const std::string model : {"elam", "preisach", "gpi"}) {
    INFO(model);
    REQUIRE(call(folder, {"fit", "fitted.csv", "--model", model, "-o", model + ".json"}).code == 0);
    const Finished late = call(folder, {"compensate", model + ".json", "late.csv"});
    INFO(late.err);
    REQUIRE(late.code == 0);
    const std::vector<Read> reads = reads_of(late.out);
    CHECK_THAT(reads.front().flags, Catch::Contains("unknown"));
    int held = 0;
    for (const Read& read : reads)
      if (!(std::abs(read.compensated - read.input) > 2.0 * read.uncertainty)) ++held;
    CHECK(held >= 0.9 * static_cast<double>(reads.size()));
    CHECK(std::abs(reads.front().compensated - reads.front().input) <= 2.0 * reads.front().uncertainty);
    CHECK_THAT(reads.back().flags, !Catch::Contains("unknown"));
    CHECK_THAT(call(folder, {"compensate", model + ".json", "whole.csv"}).out, !Catch::Contains("unknown"));
  }
}

// model diff of models of two tables whose differences are known.

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
    const auto printed = nlohmann::json::parse(diff("a", "b", more).out);
    for (const auto& one : printed.at("parameters")) found[one.at("name").get<std::string>()] = one;
    return found;
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("model diff: polynomial parameters are given in powers of the requested pressure unit") {
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

TEST_CASE("model diff: a model equals itself, models of two kinds are not compared") {
  const TwoModels models;
  CHECK(models.diff("a", "a").code == 0);
  CHECK(nlohmann::json::parse(models.diff("b", "b", {"--json"}).out).at("same") == true);
  REQUIRE(call(models.folder, {"fit", models.path("a", ".csv"), "--model", "monotone", "-q", "-o", models.path("c")})
              .code == 0);
  check_refusal(models.diff("a", "c"), 2, "TB-MODEL-DIFF", "model diff");
}
