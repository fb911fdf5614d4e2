// `tactbench run` in a folder that `tactbench init` has filled, for tests of what runs have stored.
#pragma once

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

namespace tactbench::tests {

// `tactbench init` and sensor S-1.
inline void init_bench(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
}

// The data of a report that passes or is inconclusive.
inline nlohmann::json report_data(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  const Finished made = call(folder, joined(words, {"--format", "json", "-o", "r.json"}));
  INFO(made.err);
  REQUIRE((made.code == 0 || made.code == 6));
  return nlohmann::json::parse(read_file(folder.path("r.json")));
}

// The recipe with sensor S-1 and without questions; it has to complete. `more`: further words of the command.
inline void run_recipe(const TemporaryFolder& folder, const std::string& recipe,
                       const std::vector<std::string>& more = {}) {
  const Finished run = call(folder, joined({"run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "--operator",
                                            "tester", "-q", "--no-seating", "--yes"},
                                           more));
  INFO(run.err);
  REQUIRE(run.code == 0);
}

// A bench with a smaller array, for tests that go through every step and check nothing that needs a large array.

// `tactbench init` with 4 x 16 taxels in place of 16 x 16: what is done for each taxel takes a quarter of the time.
inline void init_small_array(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init"}).code == 0);
  const auto replace = [&](const char* name, const std::string& old, const std::string& by) {
    std::string text = read_file(folder.path(name));
    const std::size_t at = text.find(old);
    REQUIRE(at != std::string::npos);
    write_file(folder.path(name), text.replace(at, old.size(), by));
  };
  replace("sensor.toml", "\nrows = 16\n", "\nrows = 4\n");
  replace("bench.toml", "\n[scanner]\n", "\n[scanner]\nrows = 4\n");
}

// A folder set up by `tactbench init`, with a recipe that takes seconds, limits that all pass, and sensor S-1.

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
