// In place of the runs that a benchmark makes of simulated sensors: short ones of few taxels, and what was asked for.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/benchmarks/simulated_run.h"

namespace tactbench::tests {

// Both sequences of Table 1 become one repeat of `production`, random reversals one full loop and one turn. A run is
// made once and given again whatever the seed of its course and its noise are, and, with `once_a_recipe`, whatever else
// is set.
class ShortRuns {
 public:
  explicit ShortRuns(int side, bool once_a_recipe = false) : side_(side), once_a_recipe_(once_a_recipe) {}
  std::vector<std::string> asked;  // file of the store, specimen, sensor and noise seed, recipes, what was set

  // To be given to a benchmark.
  bench::Simulate in_place() {
    return [this](const bench::SimulatedRun& made, const bench::SimulatedSensor& sensor, unsigned noise_seed,
                  db::RunStore& store) { return run(made, sensor, noise_seed, store); };
  }

 private:
  bench::KnownRun run(const bench::SimulatedRun& made, const bench::SimulatedSensor& sensor, unsigned noise_seed,
                      db::RunStore& store) {
    std::string words = std::filesystem::path(store.path()).filename().string() +
                        (sensor.harsh ? " harsh " : " paper ") + std::to_string(sensor.seed) + " " +
                        std::to_string(noise_seed) + ":";
    std::string key = store.path();
    for (const char* recipe : made.recipes) {
      words += std::string(" ") + recipe;
      key += std::string(" ") + recipe;
    }
    bool repeats_set = false;
    for (const std::string& set : made.set) {
      words += " " + set;
      if (!once_a_recipe_ && !set.starts_with("recipe.seed=")) key += " " + set;
      repeats_set = repeats_set || set.starts_with("recipe.repeats=");
    }
    asked.push_back(words);
    const auto found = made_.find(key);
    if (found != made_.end()) return found->second;
    bench::SimulatedRun small = made;
    const std::string recipe = made.recipes.front();
    if (recipe == "descending") small.recipes = {"production"};
    if ((recipe == "descending" || recipe == "production") && !repeats_set) small.set.emplace_back("recipe.repeats=1");
    if (recipe == "creep-levels") small.set.emplace_back("recipe.frames=20");
    if (recipe == "random-reversal") small.set.emplace_back("recipe.reversals=1");
    for (const char* set : {"scanner.rows=", "scanner.columns="}) small.set.push_back(set + std::to_string(side_));
    small.set.emplace_back("scanner.kind=frame-source");
    return made_[key] = bench::simulate_run(small, sensor, noise_seed, store);
  }
  int side_;
  bool once_a_recipe_;
  std::map<std::string, bench::KnownRun> made_;
};

}  // namespace tactbench::tests
