// The tables of keys: each row says all that a reader needs, each key that a shipped file holds or that reading it
// takes by default is a row, and the files of init hold a comment for each of their keys and the same values.
#include "bench/cli/rig/key_pages.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/nightly/suite.h"
#include "bench/run/recipe_check.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::string values_of(const std::string& toml) { return sequences::TomlDocument::from_text(toml, "t").to_text(); }

// "environment.sensor[0].serial" as "environment.sensor[].serial".
std::string without_numbers(std::string key) {
  std::erase_if(key, [](char c) { return c >= '0' && c <= '9'; });
  return key;
}

}  // namespace

TEST_CASE("each row of a table of keys has a type, a unit and a meaning, and each key one row") {
  for (const bench::FileKind& kind : bench::file_kinds()) {
    INFO(kind.title);
    std::set<std::string> keys;
    for (const sequences::KeyFacts& row : kind.keys()) {
      INFO(row.key);
      CHECK(keys.insert(row.key).second);
      CHECK((!row.type.empty() && !row.unit.empty() && row.meaning.size() > 8));
    }
    CHECK(keys.contains("schema"));
  }
}

TEST_CASE("each shipped file is read, and of a bench file each value that is read is a row") {
  std::set<std::string> rows;
  for (const sequences::KeyFacts& row : bench::bench_keys()) rows.insert(without_numbers(row.key));
  for (const char* name : {"simulated.toml", "simulated-serial.toml", "paper-rig.example.toml"})
    for (const sequences::Setting& setting : bench::read_bench(bench::find_config(name), {}).settings) {
      INFO(setting.key);
      CHECK(rows.contains(without_numbers(setting.key)));
    }
  CHECK_NOTHROW(bench::read_sensor_type(bench::find_config("sensor.toml")));
  CHECK_NOTHROW(bench::read_laboratory(bench::find_config("lab.toml")));
  for (const char* name : {"limits.toml", "nightly-limits.toml"})
    CHECK_NOTHROW(bench::read_limits(bench::find_config(name)));
  for (const std::string& profile : bench::shipped_profiles()) CHECK_NOTHROW(bench::read_module_profile(profile));
  for (const std::string& name : bench::shipped_files("sequences")) {
    INFO(name);
    if (name == "nightly.toml")
      CHECK_NOTHROW(bench::read_suite(bench::find_recipe(name)));
    else
      CHECK_NOTHROW(bench::read_recipe_file(name));
  }
}

TEST_CASE("a file with the meanings of its keys holds each meaning once and keeps its values") {
  const std::string toml =
      "schema = 1\n[settling]\npoll_s = 0.2\n# trace_s = 0\n[stage.x]\ndevice = 1\n[stage.y]\ndevice = 2\n[other]\nx = "
      "1\n";
  const std::vector<sequences::KeyFacts> keys = bench::bench_keys();
  const std::string text = bench::with_meanings(toml, keys);
  CHECK(values_of(text) == values_of(toml));
  for (const char* key : {"schema", "settling.poll_s", "settling.trace_s", "stage.x.device", "stage.y.device"}) {
    INFO(key);
    const auto row = std::ranges::find(keys, key, &sequences::KeyFacts::key);
    REQUIRE(row != keys.end());
    CHECK(text.find("# " + row->meaning.substr(0, 40)) != std::string::npos);
  }
  for (const char* name : {"simulated.toml", "simulated-serial.toml", "paper-rig.example.toml"}) {
    const std::string shipped = read_file(bench::find_config(name));
    CHECK(values_of(bench::with_meanings(shipped, keys)) == values_of(shipped));
  }
}
