#include "sequences/recipe.h"

#include <catch2/catch.hpp>

using namespace tactbench::sequences;
using tactbench::devices::Psi;

namespace {

const std::string kRecipes = std::string(TACTBENCH_SOURCE_DIR) + "/sequences/";

int measuring(const std::vector<Step>& steps, int repeat) {
  int count = 0;
  for (const Step& step : steps) count += step.kind == StepKind::kMeasure && step.repeat == repeat ? 1 : 0;
  return count;
}

Recipe recipe_of(const std::string& body) {
  return parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\n" + body, "test.toml"));
}

}  // namespace

TEST_CASE("the paper's sequences have 211 and 451 frames a repeat and 3310 in all") {
  const Recipe descending = read_recipe(kRecipes + "descending.toml");
  const Recipe ascending = read_recipe(kRecipes + "ascending.toml");
  for (int repeat = 0; repeat < 5; ++repeat) {
    CHECK(measuring(compile(descending, 0), repeat) == 211);
    CHECK(measuring(compile(ascending, 0), repeat) == 451);
  }
  const Estimate both = estimate(compile({descending, ascending}), 60.0, 0.4, 1024.0);
  CHECK(both.frames == 3310);
  CHECK(both.highest == Psi(60.0));
  CHECK(both.lowest == Psi(0.0));
  CHECK(both.seconds > 3310 * 2.0);
}

TEST_CASE("steps visit every level of every branch once, turning points exactly") {
  const auto steps = compile(recipe_of("turning_points = [0, 6, 2, 6, 0]\nstep = 2\ndwell_s = 1\n"), 3);
  std::vector<double> levels;
  std::vector<int> branches;
  for (const Step& step : steps) {
    levels.push_back(step.setpoint.value());
    branches.push_back(step.branch);
    CHECK(step.ordinal == static_cast<int>(levels.size()) - 1);
    CHECK(step.sequence == 3);
  }
  CHECK(levels == std::vector<double>{0, 2, 4, 6, 4, 2, 4, 6, 4, 2, 0});
  CHECK(branches == std::vector<int>{0, 0, 0, 0, 1, 1, 2, 2, 3, 3, 3});
}

TEST_CASE("conditioning cycles come first and take no frame") {
  const auto steps =
      compile(recipe_of("turning_points = [0, 2]\nstep = 2\n[conditioning]\ncycles = 2\npeak = 60\n"), 0);
  REQUIRE(steps.size() == 6);
  for (int i = 0; i < 4; ++i) {
    CHECK(steps[i].kind == StepKind::kConditioning);
    CHECK(steps[i].setpoint == Psi(i % 2 == 0 ? 60.0 : 0.0));
  }
  CHECK(estimate(steps, 60.0, 0.4, 0.0).frames == 2);
}

TEST_CASE("a recipe in kPa or bar is brought to psi") {
  const Recipe kpa = parse_recipe(
      TomlDocument::from_text("schema=1\nname=\"k\"\nunit=\"kPa\"\nturning_points=[0, 100]\nstep=50\n", "k.toml"));
  CHECK(kpa.turning_points[1].value() == Approx(14.503773773));
  const Recipe bar = parse_recipe(
      TomlDocument::from_text("schema=1\nname=\"k\"\nunit=\"bar\"\nturning_points=[0, 1]\nstep=0.5\n", "k.toml"));
  CHECK(bar.turning_points[1].value() == Approx(14.503773773));
}

TEST_CASE("a bad recipe names file, line, key and remedy") {
  const auto refused = [](const std::string& body, const std::string& message, const std::string& where) {
    try {
      (void)recipe_of(body);
      FAIL("accepted: " << body);
    } catch (const FileError& error) {
      CHECK_THAT(error.what(), Catch::Contains(message));
      CHECK_THAT(error.where(), Catch::Contains(where));
      CHECK(!error.remedy().empty());
    }
  };
  const std::string good = "turning_points = [0, 60]\nstep = 2\n";
  refused(good + "dwel_s = 2\n", "unknown key 'dwel_s'", "test.toml:6:");
  refused(good + "dwell_s = \"2 s\"\n", "must be a number", "test.toml:6:");
  refused(good + "dwell_s = 2 s\n", "not valid TOML", "test.toml:6:");
  refused(good + "repeats = 0\n", "not a whole number from 1", "repeats");
  refused(good + "repeats = 1.5\n", "not a whole number", "repeats");
  refused("turning_points = [0, 61]\nstep = 2\n", "not a whole number of steps", "turning_points");
  refused("turning_points = [0, 0]\nstep = 2\n", "not a whole number of steps", "turning_points");
  refused("turning_points = [0, -2]\nstep = 2\n", "negative", "turning_points");
  refused("turning_points = [0]\nstep = 2\n", "fewer than two", "turning_points");
  refused("turning_points = [0, 60]\n", "'step' is missing", "step");
  refused("turning_points = [0, 60]\nstep = 0\n", "above 0", "step");
  refused("turning_points = [0, nan]\nstep = 2\n", "not a finite number", "turning_points");
  refused(good + "[conditioning]\ncycles = 1\n", "'peak' is missing", "conditioning.peak");
  refused(good + "step = 4\n", "not valid TOML", "test.toml:6:");
}

TEST_CASE("a wrong unit is an error, not a guess") {
  try {
    (void)parse_recipe(
        TomlDocument::from_text("schema=1\nname=\"x\"\nunit=\"PSI\"\nturning_points=[0,2]\nstep=2\n", "u"));
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("not one of psi, kPa, bar"));
    CHECK_THAT(error.remedy(), Catch::Contains("psi"));
  }
}

TEST_CASE("overrides replace values and are checked like the file") {
  const Recipe once = read_recipe(kRecipes + "descending.toml", {{"repeats", "1"}, {"conditioning.cycles", "0"}});
  CHECK(once.repeats == 1);
  CHECK(once.conditioning_cycles == 0);
  CHECK_THROWS_AS(read_recipe(kRecipes + "descending.toml", {{"repeat", "1"}}), FileError);
  CHECK_THROWS_AS(read_recipe(kRecipes + "descending.toml", {{"name.x", "1"}}), FileError);
  CHECK_THROWS_AS(read_recipe(kRecipes + "no-such.toml"), FileError);
}

TEST_CASE("the nearest word is found, a far one is not") {
  CHECK(nearest_word("reprot", {"run", "report", "fit"}) == "report");
  CHECK(nearest_word("zzzzzz", {"run", "report", "fit"}).empty());
}

TEST_CASE("a key of 200000 parts is refused, not recursed into") {
  std::string key = "a";
  for (int i = 0; i < 200'000; ++i) key += ".a";
  try {
    (void)TomlDocument::from_text("schema = 1\n" + key + " = 1\n", "deep.toml");
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK(error.id() == "TB-FILE-SYNTAX");
    CHECK(error.where() == "deep.toml:2");
  }
}
