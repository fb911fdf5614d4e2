// The rig's own check as a person uses it: a changed rig is distinguished from a changed standard.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE("rig check separates a changed rig from a changed standard") {
  const TemporaryFolder folder;
  const auto call = [&](std::vector<std::string> words) {
    return run_program(program_path(), std::move(words), folder.path());
  };
  REQUIRE(call({"init"}).code == 0);
  REQUIRE(call({"sensors", "add", "STD-1", "--type", "sensor.toml"}).code == 0);
  const auto check = [&](const std::string& seed, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"rig",    "check",      "--bench", "bench.toml",      "--standard",
                                      "STD-1",  "--operator", "test",    "--seed",          seed,
                                      "--json", "-q",         "--set",   "recipe.repeats=2"};
    words.insert(words.end(), more.begin(), more.end());
    return call(words);
  };
  for (const char* seed : {"1", "2", "3", "4", "5", "6", "7", "8"}) {
    const Finished first = check(seed, {});
    INFO(first.err << first.out);
    REQUIRE(first.code == 0);
    CHECK_THAT(nlohmann::json::parse(first.out).at("conclusion"), Catch::StartsWith("not judged"));
  }
  REQUIRE(call({"baseline", "accept", "1-16", "--by", "K. Lee", "--reason", "after service"}).code == 0);
  const Finished well = check("9", {});
  INFO(well.err << well.out);
  CHECK(well.code == 0);
  CHECK_THAT(nlohmann::json::parse(well.out).at("conclusion"), Catch::StartsWith("rig and standard are unchanged"));
  const Finished rig = check("10", {"--set", "simulation.chamber.hysteresis_share=0.01"});
  INFO(rig.err << rig.out);
  CHECK(rig.code == 1);
  CHECK_THAT(nlohmann::json::parse(rig.out).at("conclusion"), Catch::StartsWith("the rig changed"));
  const Finished standard = check("11", {"--set", R"(simulation.defect=[{kind="dead",row=3,column=4}])"});
  INFO(standard.err << standard.out);
  CHECK(standard.code == 1);
  CHECK_THAT(nlohmann::json::parse(standard.out).at("conclusion"), Catch::StartsWith("the standard changed"));
  CHECK(call({"rig", "check", "--bench", "bench.toml", "--standard", "none", "--operator", "t"}).code == 2);
}
