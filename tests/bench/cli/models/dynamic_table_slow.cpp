// The dynamic model of a table with times: recordings of one taxel of the simulated film, which creeps and lags.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/simulation/specimen.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using Turns = std::vector<double>;

// A recording every 0.2 s: 4 psi a second from turn to turn, rests of 3 s at each.
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
    "fit of a table with times: the dynamic model is better compensated than Preisach's, whatever rises or falls") {
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

TEST_CASE(
    "fit of a table: what has no times, or no unloaded sensor, has no dynamic model, and its stream wants times") {
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
