// Which runs of simulated sensors `benchmark compensation-error` and `benchmark coverage` take: whole tables.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/benchmarks/compensation_error.h"
#include "bench/benchmarks/coverage.h"

using namespace tactbench::bench;

namespace {

std::string run_in_words(const SimulatedRun& run) {
  std::string words;
  for (const char* recipe : run.recipes) words += std::string(recipe) + " ";
  for (const std::string& set : run.set) words += set + " ";
  return words;
}

constexpr const char* kMonth =
    "simulation.temperature_c=28 simulation.age_months=1 simulation.effects.gain_drift_per_month=0.01 "
    "simulation.effects.zero_drift_v_per_month=0.01 ";

}  // namespace

TEST_CASE("benchmark compensation-error: the run of each condition") {
  const std::string month = kMonth, mount = "simulation.mount_seed=1 simulation.effects.remount_variation=0.03 ";
  std::vector<std::string> lines;
  for (const ConditionRun& run : compensation_error_runs())
    lines.push_back(run.condition + ": " + run_in_words(run.made));
  CHECK(lines ==
        std::vector<std::string>{
            "random_1: random-reversal recipe.seed=1 ", "random_2: random-reversal recipe.seed=7 ",
            "dwell_0.2_s: random-reversal recipe.dwell_s=0.2 ", "dwell_10_s: random-reversal recipe.dwell_s=10 ",
            "random_to_54_psi: random-reversal recipe.random.high=54 ", "same: descending ascending recipe.repeats=1 ",
            "remounted: descending ascending " + mount + "recipe.repeats=1 ",
            "month_and_5_degrees: descending ascending " + month + "recipe.repeats=1 ",
            "remounted_random: random-reversal " + mount, "month_and_5_degrees_random: random-reversal " + month});
}

TEST_CASE("benchmark coverage: the uses of a sensor, those of its calibration first") {
  std::vector<std::string> lines;
  for (const SensorUse& use : coverage_uses())
    lines.push_back(use.name + (use.full_sweeps ? " (full sweeps): " : ": ") + run_in_words(use.made));
  CHECK(lines == std::vector<std::string>{
                     "full_sweeps (full sweeps): ", "inner_branches: ", "random_reversals: random-reversal ",
                     "other_dwell: random-reversal recipe.dwell_s=10 ", "held: random-reversal recipe.dwell_s=25 ",
                     "other_temperature: random-reversal simulation.temperature_c=28 ",
                     "remounted: random-reversal simulation.effects.remount_variation=0.03 ",
                     std::string("month_later: random-reversal ") + kMonth});
}
