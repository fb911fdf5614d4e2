// The libraries in use with their versions, as selfcheck's record names them.
#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/selfcheck/selfcheck.h"

using namespace tactbench::bench;

TEST_CASE("selfcheck libraries: each is listed once by name, with the version of its headers") {
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
  const auto number = [](int major, int minor, int patch) {
    return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
  };
  CHECK(version_of("fmt") == number(FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100));
  CHECK(version_of("CLI11") == CLI11_VERSION);
  CHECK(version_of("nlohmann-json") ==
        number(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH));
}
