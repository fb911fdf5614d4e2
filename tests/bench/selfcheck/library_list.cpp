// The libraries in use with their versions, as selfcheck's record names them.
#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/selfcheck/selfcheck.h"

using namespace tactbench::bench;

TEST_CASE("selfcheck's libraries: each once by name, those of this room with the numbers of their headers") {
  const auto versions = library_versions();
  CHECK(versions.size() >= 10);
  CHECK(std::ranges::is_sorted(versions));
  std::vector<std::string> names;
  for (const auto& [name, version] : versions) {
    INFO(name);
    CHECK_FALSE(version.empty());
    names.push_back(name);
  }
  CHECK(std::ranges::adjacent_find(names) == names.end());
  const auto version_of = [&](const std::string& name) {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? std::string() : versions[static_cast<std::size_t>(found - names.begin())].second;
  };
  int major = 0, minor = 0, patch = 0;
  REQUIRE(std::sscanf(version_of("fmt").c_str(), "%d.%d.%d", &major, &minor, &patch) == 3);
  CHECK(major * 10000 + minor * 100 + patch == FMT_VERSION);
  CHECK((minor < 100 && patch < 100));
  CHECK(version_of("CLI11") == CLI11_VERSION);
  REQUIRE(std::sscanf(version_of("nlohmann-json").c_str(), "%d.%d.%d", &major, &minor, &patch) == 3);
  CHECK((major == NLOHMANN_JSON_VERSION_MAJOR && minor == NLOHMANN_JSON_VERSION_MINOR &&
         patch == NLOHMANN_JSON_VERSION_PATCH));
}
