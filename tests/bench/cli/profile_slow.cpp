// tactbench.toml, TACTBENCH_BENCH and TACTBENCH_DB as a person meets them.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/small_bench.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

struct SetVariable {
  SetVariable(const char* variable, const char* value) : name(variable) { setenv(name, value, 1); }
  ~SetVariable() { unsetenv(name); }
  SetVariable(const SetVariable&) = delete;
  SetVariable& operator=(const SetVariable&) = delete;
  const char* name;
};

}  // namespace

TEST_CASE("with init --operator nothing is typed twice: run takes bench, recipe, operator and store of the file") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "A. \"Q\" Person"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  well(call(folder, {"run", "--sensor", "S-1", "-q"}));
  const json shown = json::parse(call(folder, {"runs", "show", "1", "--json"}).out);
  CHECK(shown.at("operator") == "A. \"Q\" Person");
  REQUIRE(shown.at("recipes").size() == 3);  // of `production`
  CHECK(shown.at("recipes").at(0).at("name") == "loops");
  CHECK(call(folder, {"init", "--operator", " "}).code == 2);
}

TEST_CASE("the environment's store precedes the file's, and a typed one both") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "db = \"file.db\"\n");
  const auto made = [&](const char* name) { return std::filesystem::exists(folder.path(name)); };
  REQUIRE(call(folder, {"init", "types"}).code == 0);
  const std::vector<std::string> add = {"sensors", "add", "S-1", "--type", "types/sensor.toml"};
  REQUIRE(call(folder, add).code == 0);
  CHECK(made("file.db"));
  const SetVariable db("TACTBENCH_DB", "environment.db");
  REQUIRE(call(folder, add).code == 0);
  CHECK(made("environment.db"));
  REQUIRE(call(folder, joined_words(add, {"--db", "typed.db"})).code == 0);
  CHECK(made("typed.db"));
  CHECK(!made("runs.db"));
}

TEST_CASE("config says where each value of the profile comes from") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "operator = \"me\"\nbench = \"no-such.toml\"\n");
  const SetVariable bench("TACTBENCH_BENCH", "simulated.toml");
  const Finished shown = call(folder, {"config", "--origin"});
  INFO(shown.err);
  REQUIRE(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains("profile.bench = \"simulated.toml\"") && Catch::Contains("# TACTBENCH_BENCH") &&
                            Catch::Contains("profile.operator = \"me\"") && Catch::Contains("# tactbench.toml:1"));
  const json list = json::parse(call(folder, {"config", "--json"}).out).at("profile");
  REQUIRE(list.size() == 2);
  CHECK(list.at(0) == json{{"key", "profile.bench"}, {"value", "\"simulated.toml\""}, {"origin", "TACTBENCH_BENCH"}});
}

TEST_CASE("a wrong profile is an error with its line, but keeps nobody from help, nor from stopping a run") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "bench = \"simulated.toml\"\noperater = \"me\"\n");
  const Finished list = call(folder, {"runs", "list"});
  CHECK(list.code == 2);
  CHECK_THAT(list.err,
             Catch::Contains("[TB-FILE-KEY]") && Catch::Contains("tactbench.toml:2") && Catch::Contains("'operator'"));
  CHECK(call(folder, {"runs", "list", "--help"}).code == 0);
  for (const char* command : {"pause", "stop", "panic"})
    CHECK_THAT(call(folder, {command}).err, Catch::Contains("[TB-RUN-NOT-LIVE]"));
}

TEST_CASE("judge takes the profile's limits and says so, fit none") {
  const TemporaryFolder folder;
  begin_bench(folder, small_loop_text(10, 2));
  write_file(folder.path("hard.toml"), limits_text("simple", 0.000001));
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
  write_file(folder.path("tactbench.toml"), "limits = \"hard.toml\"\n");
  well(call(folder, {"fit", "1"}));
  CHECK_THAT(well(call(folder, {"fit", "1"}, {"judge", "1", "2"}), 1).err, Catch::Contains("tactbench.toml:1"));
  well(call(folder, {"report", "1"}), 1);
}
