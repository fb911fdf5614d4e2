// The method in words: sweeps, levels, waiting times, conditioning, from the recipe and what was set.
#include <catch2/catch.hpp>

#include "bench/config/config.h"
#include "bench/reporting/study_roles.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

db::RunRecord run_of(const std::string& recipe_toml, const std::string& overrides = "[]") {
  db::RunRecord run;
  run.overrides_json = overrides;
  run.sequences = {{0, "a", recipe_toml, "", 1, 1}};
  return run;
}

std::string shipped_text(const std::string& recipe) { return tests::read_file(find_recipe(recipe)); }

}  // namespace

TEST_CASE("method text: states the settings of the recipe and its overrides") {
  const std::string toml = shipped_text("descending");
  REQUIRE(method_descriptions(run_of(toml)).size() == 1);
  const std::string set = method_descriptions(run_of(toml, R"([{"key":"recipe.dwell_s","value":"2.5"},)"
                                                           R"({"key":"recipe.repeats","value":"1"}])"))
                              .front();
  CHECK_THAT(set, Catch::StartsWith("1 ") && Catch::Contains("2.5 s"));
  CHECK(method_descriptions(run_of("no recipe")) == std::vector<std::string>{""});
}
