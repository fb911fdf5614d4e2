// `benchmark compensation-error` on few taxels and short runs: the runs it makes, and its figures as they were
// recorded.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/benchmarks/compensation_error.h"
#include "tests/bench/benchmarks/short_runs.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

std::vector<std::string> expected_runs_of(const std::string& start) {
  const std::string month =
      " simulation.temperature_c=28 simulation.age_months=1 simulation.effects.gain_drift_per_month=0.01 "
      "simulation.effects.zero_drift_v_per_month=0.01";
  const std::string mount = " simulation.mount_seed=1 simulation.effects.remount_variation=0.03";
  const std::string both = " descending ascending", random = " random-reversal", once = " recipe.repeats=1";
  std::vector<std::string> lines;
  int seed = 0;
  for (const std::string& words :
       {both, std::string(" rate"), std::string(" creep-levels"), random + " recipe.seed=1", random + " recipe.seed=7",
        random + " recipe.dwell_s=0.2", random + " recipe.dwell_s=10", random + " recipe.random.high=54", both + once,
        both + mount + once, both + month + once, random + mount, random + month})
    lines.push_back(fmt::format("{} {}:{}", start, ++seed, words));
  return lines;
}

// Of the short runs; in the order in which they are printed.
constexpr std::pair<const char*, double> kRecordedErrors[] = {
    {"random_1", 0.528},
    {"random_1_most", 7.156},
    {"random_1_within_2_u", 93.28},
    {"random_1_one_run", 0.2997},
    {"random_1_one_run_most", 5.712},
    {"random_1_one_run_within_2_u", 89},
    {"random_1_elam_stream", 0.3272},
    {"random_1_elam_stream_most", 4.124},
    {"random_1_elam_stream_within_2_u", 98.1},
    {"same", 0.3054},
    {"same_most", 6.373},
    {"same_within_2_u", 99.32},
    {"same_one_run", 0.2376},
    {"same_one_run_most", 5.487},
    {"same_one_run_within_2_u", 99.69},
    {"same_elam_stream", 0.267},
    {"same_elam_stream_most", 5.111},
    {"same_elam_stream_within_2_u", 100},
    {"random_1_elam", 0.4434},
    {"random_1_monotone", 4.599},
    {"random_1_mpi", 4.339},
    {"random_1_poly", 1.882},
    {"random_1_preisach", 0.9588},
    {"same_elam", 0.4128},
    {"same_monotone", 4.89},
    {"same_mpi", 5.1},
    {"same_poly", 2.214},
    {"same_preisach", 1.022},
    {"harsh_random_1", 0.8269},
    {"harsh_random_1_most", 10.32},
    {"harsh_random_1_within_2_u", 97.15},
    {"harsh_random_1_one_run", 0.6587},
    {"harsh_random_1_one_run_most", 5.49},
    {"harsh_random_1_one_run_within_2_u", 93.83},
    {"harsh_random_1_elam_stream", 0.743},
    {"harsh_random_1_elam_stream_most", 10.4},
    {"harsh_random_1_elam_stream_within_2_u", 99.68},
    {"harsh_random_1_of_elam_stream", 1.113},
    {"harsh_same", 0.5869},
    {"harsh_same_most", 5.393},
    {"harsh_same_within_2_u", 99.75},
    {"harsh_same_one_run", 0.8942},
    {"harsh_same_one_run_most", 11.7},
    {"harsh_same_one_run_within_2_u", 100},
    {"harsh_same_elam_stream", 1.225},
    {"harsh_same_elam_stream_most", 15.89},
    {"harsh_same_elam_stream_within_2_u", 100},
    {"harsh_same_of_elam_stream", 0.4789},
    {"harsh_random_1_elam", 1.563},
    {"harsh_random_1_monotone", 5.327},
    {"harsh_random_1_mpi", 3.943},
    {"harsh_random_1_poly", 2.672},
    {"harsh_random_1_preisach", 1.362},
    {"harsh_same_elam", 1.968},
    {"harsh_same_monotone", 5.827},
    {"harsh_same_mpi", 5.346},
    {"harsh_same_poly", 2.962},
    {"harsh_same_preisach", 1.574},
};

}  // namespace

TEST_CASE("benchmark compensation-error: the runs of each specimen, and all models on every eighth taxel") {
  const tests::TemporaryFolder folder;
  tests::ShortRuns runs(4, true);
  const std::vector<Figure> figures = benchmark_compensation_error({31}, folder.path(), true, runs.in_place());
  std::vector<std::string> expected = expected_runs_of("31-paper.db paper 31");
  const std::vector<std::string> harsh = expected_runs_of("31-harsh.db harsh 31");
  expected.insert(expected.end(), harsh.begin(), harsh.end());
  CHECK(runs.asked == expected);
  std::map<std::string, double> named;
  for (const Figure& figure : figures) CHECK(named.emplace(figure.name.substr(19), figure.value).second);
  for (const auto& [name, value] : kRecordedErrors) {
    INFO(name);
    REQUIRE(named.contains(name));
    CHECK(named.at(name) == Approx(value).epsilon(2e-3));
  }
  // All models as they are and on the linearised output: of such short runs no divider is found, and both are the same.
  int models = 0;
  for (const auto& [name, value] : named) {
    if (!name.ends_with("_linearised")) continue;
    ++models;
    CHECK(named.at(name.substr(0, name.size() - 11)) == value);
  }
  CHECK(models == 2 * 10 * 6);
}
