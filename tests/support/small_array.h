// A bench with a smaller array, for tests that go through every step and check nothing that needs a large array.
#pragma once

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/process.h"

namespace tactbench::tests {

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

}  // namespace tactbench::tests
