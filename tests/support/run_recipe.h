// `tactbench run` in a folder that `tactbench init` has filled, for tests of what runs have stored.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace tactbench::tests {

// The recipe with sensor S-1 and without questions; it has to complete. `more`: further words of the command.
inline void run_recipe(const TemporaryFolder& folder, const std::string& recipe,
                       const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"run",        recipe,   "--bench", "bench.toml",   "--sensor", "S-1",
                                 "--operator", "tester", "-q",      "--no-seating", "--yes"};
  words.insert(words.end(), more.begin(), more.end());
  const Finished run = call(folder, words);
  INFO(run.err);
  REQUIRE(run.code == 0);
}

}  // namespace tactbench::tests
