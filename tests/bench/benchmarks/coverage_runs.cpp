// `benchmark coverage`: which runs it makes of each sensor, with which seeds, before it fits anything.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/benchmarks/coverage.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

using RunLines = std::vector<std::string>;

constexpr std::size_t kOfOneSensor = 3 + 6 * 8 + 4;  // runs before the first fit

// The runs that are asked for up to the first fit, which never comes. Run n of the store is the n-th one.
RunLines runs_asked_for(const CoverageOptions& options, const tests::TemporaryFolder& folder) {
  RunLines lines;
  const auto simulate = [&](const SimulatedRun& made, const SimulatedSensor& sensor, unsigned noise_seed,
                            db::RunStore& store) {
    std::string line = fmt::format("{} {} {} {}:", std::filesystem::path(store.path()).filename().string(),
                                   sensor.harsh ? "harsh" : "paper", sensor.seed, noise_seed);
    for (const char* recipe : made.recipes) line += fmt::format(" {}", recipe);
    for (const std::string& set : made.set) line += " " + set;
    lines.push_back(line);
    if (lines.size() == kOfOneSensor) throw std::runtime_error("enough");
    KnownRun run;
    run.data.run = static_cast<std::int64_t>(lines.size());
    return run;
  };
  CHECK_THROWS_WITH(benchmark_coverage(options, folder.path(), simulate), "enough");
  return lines;
}

const std::string kThermometerSet =
    " environment.sensor=[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], "
    "span_c = [-100, 100]}]";

RunLines expected_runs(const std::string& start, unsigned sensor, const std::string& calibration) {
  RunLines lines;
  unsigned noise = 0;
  const std::string instruments = fmt::format(" simulation.instrument_seed={}", sensor);
  const auto add = [&](const std::string& rest) {
    lines.push_back(fmt::format("{} {}:{}{}", start, ++noise, rest, instruments));
  };
  add(" rate");
  add(" creep-levels");
  add(" production" + kThermometerSet + " recipe.repeats=1 simulation.temperature_c=28");
  const std::string month =
      " simulation.temperature_c=28 simulation.age_months=1 simulation.effects.gain_drift_per_month=0.01 "
      "simulation.effects.zero_drift_v_per_month=0.01";
  for (const std::string& use :
       {std::string(), std::string(" recipe.dwell_s=10"), std::string(" recipe.dwell_s=25"),
        std::string(" simulation.temperature_c=28"), std::string(" simulation.effects.remount_variation=0.03"), month})
    for (int i = 0; i < 5 + 3; ++i) {
      const unsigned drawn = 1000 * sensor + noise + 1;  // each goes its own way, and is of a mount of its own
      const bool mounted = use.find("remount") != std::string::npos;
      add(" random-reversal" + use + fmt::format(" recipe.seed={}", drawn) +
          (mounted ? fmt::format(" simulation.mount_seed={}", drawn) : ""));
    }
  add(calibration + kThermometerSet);
  for (int i = 0; i < 3; ++i) add(calibration);
  return lines;
}

}  // namespace

TEST_CASE("benchmark coverage: the runs of the paper's sensor and of the harsh one, each calibration") {
  const tests::TemporaryFolder folder;
  CoverageOptions options;
  options.sensor_seeds = {4101, 7};
  options.table_1 = false;
  CHECK(runs_asked_for(options, folder) == expected_runs("4101-paper.db paper 4101", 4101, " production"));
  options.paper = false;
  options.table_1 = true;
  options.production = false;
  options.sensor_seeds = {12};
  CHECK(runs_asked_for(options, folder) == expected_runs("12-harsh.db harsh 12", 12, " descending ascending"));
}

TEST_CASE("benchmark coverage: without specimens there is nothing to tell") {
  const tests::TemporaryFolder folder;
  CoverageOptions options;
  options.sensor_seeds = {1};
  options.paper = options.harsh = false;
  int runs = 0;
  CHECK(benchmark_coverage(options, folder.path(), [&](const auto&, const auto&, unsigned, db::RunStore&) {
          ++runs;
          return KnownRun();
        }).empty());
  CHECK(runs == 0);
}
