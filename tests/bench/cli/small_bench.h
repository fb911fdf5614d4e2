// A folder set up by `tactbench init`, with a recipe that takes seconds, limits that all pass, and sensor S-1.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// small.toml: with an inner loop.
inline std::string small_loop_text(int step = 20, int repeats = 1) {
  return "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\ndwell_s = 1.0\nstep = " +
         std::to_string(step) + "\nrepeats = " + std::to_string(repeats) + "\n";
}

inline std::string limits_text(const std::string& rule, double mean_error_psi) {
  return "schema = 1\nname = \"of-a-test\"\nrule = \"" + rule +
         "\"\nmean_compensation_error_psi = " + std::to_string(mean_error_psi) +
         "\nworst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 256\n";
}

inline void begin_bench(const TemporaryFolder& folder, const std::string& recipe = small_loop_text()) {
  well(call(folder, {"init"}));
  well(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}));
  write_file(folder.path("small.toml"), recipe);
  write_file(folder.path("wide.toml"), limits_text("simple", 60));
}

// small.toml on it, with the check of its seating.
inline void measure_small(const TemporaryFolder& folder, const std::string& seed = "1") {
  well(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q",
                     "--seed", seed}));
}

}  // namespace tactbench::tests
