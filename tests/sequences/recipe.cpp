#include "sequences/recipe.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "sequences/estimate.h"
#include "tests/sequences/recipe_text.h"
#include "tests/support/paths.h"

using namespace tactbench::sequences;
using tactbench::devices::Psi;

namespace {

const std::string kRecipes = tactbench::tests::source_path("sequences/");

int measuring(const std::vector<Step>& steps, int repeat) {
  int count = 0;
  for (const Step& step : steps) count += step.kind == StepKind::kMeasure && step.repeat == repeat ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("the paper's sequences have 211 and 451 frames a repeat and 3310 in all") {
  const Recipe descending = read_recipe(kRecipes + "descending.toml");
  const Recipe ascending = read_recipe(kRecipes + "ascending.toml");
  for (int repeat = 0; repeat < 5; ++repeat) {
    CHECK(measuring(compile(descending, 0), repeat) == 211);
    CHECK(measuring(compile(ascending, 0), repeat) == 451);
  }
  const std::vector<Recipe> both = {descending, ascending};
  const Estimate all = estimate(both, compile(both), TimeModel(), 1024.0);
  CHECK(all.frames == 3310);
  CHECK(all.time.low_s > 3310 * 2.0);
  CHECK(all.time.low_s < all.time.likely_s);
  CHECK(all.time.likely_s < all.time.high_s);
  CHECK(extremes(compile(both)).highest == Psi(60.0));
  CHECK(extremes(compile(both)).lowest == Psi(0.0));
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

TEST_CASE("a ramp without stops names its rate and settles only at its start") {
  const auto steps =
      compile(recipe_of("turning_points = [0, 4, 0]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = [0.5, 8]\n"), 0);
  REQUIRE(steps.size() == 10);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CHECK(steps[i].settle == (i % 5 == 0));
    CHECK(steps[i].dwell_s == 0.0);
    CHECK(steps[i].ramp_psi_per_s == (i < 5 ? 0.5 : 8.0));
  }
  CHECK(extremes(steps).fastest_ramp_psi_per_s == 8.0);
}

TEST_CASE("the way back conditions and travels to where the branch starts, without a frame") {
  const Recipe recipe =
      recipe_of("turning_points = [0, 60, 10, 60, 0]\nstep = 10\ndwell_s = 1\n[conditioning]\ncycles = 2\npeak = 50\n");
  const auto levels = [](const std::vector<Step>& steps) {
    std::vector<double> found;
    for (const Step& step : steps) {
      CHECK(step.kind == StepKind::kConditioning);
      CHECK(!takes_frame(step));
      found.push_back(step.setpoint.value());
    }
    return found;
  };
  CHECK(levels(way_back(recipe, 0, 0, 0)) == std::vector<double>{50, 0, 50, 0});
  CHECK(levels(way_back(recipe, 0, 3, 2)) == std::vector<double>{50, 0, 50, 0, 0, 60, 10});
  const Recipe bare = recipe_of("turning_points = [0, 60, 10, 60, 0]\nstep = 10\n");
  CHECK(levels(way_back(bare, 0, 0, 1)) == std::vector<double>{60, 0, 0, 60});
  // Only cycles may be skipped by a criterion: they have branch -1.
  const auto steps = way_back(recipe, 4, 3, 2);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CHECK((steps[i].branch < 0) == (i < 4));
    CHECK(steps[i].sequence == 4);
  }
  // The turning points after them belong to the branches that they end.
  REQUIRE(steps.size() == 7);
  const std::vector<double> from = {0, 0, 60}, to = {0, 60, 10};
  const std::vector<int> branch = {0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(steps[4 + i].branch == branch[i]);
    CHECK(steps[4 + i].branch_from == Psi(from[i]));
    CHECK(steps[4 + i].branch_to == Psi(to[i]));
  }
}

TEST_CASE("the way back settles at every level, also in a recipe whose ramps do not stop") {
  const Recipe ramps = recipe_of("turning_points = [0, 4, 2, 4]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = 0.5\n");
  const auto back = way_back(ramps, 0, 0, 2);
  REQUIRE(back.size() == 5);  // a cycle to the highest level, then 0, 4, 2
  for (const Step& step : back) CHECK(step.settle);
}

TEST_CASE("every branch of every shipped levels recipe starts where its way back ends") {
  for (const char* name : {"descending", "ascending", "production", "random-reversal", "rate", "creep-hold"}) {
    const Recipe recipe = read_recipe(kRecipes + name + ".toml");
    const auto steps = compile(recipe, 0);
    for (const BranchSpan& span : branches(steps)) {
      if (span.kind != SpanKind::kBranch || span.key.repeat > 1) continue;
      const Step& first = steps[span.first];
      const auto back = way_back(recipe, 0, span.key.repeat, span.key.branch);
      CHECK(back.back().setpoint == first.branch_from);
    }
  }
}

TEST_CASE("spans cover all steps once and name the branches") {
  const auto steps =
      compile(recipe_of("turning_points = [0, 4, 0]\nstep = 2\nrepeats = 2\n[conditioning]\ncycles = 2\npeak = 4\n"
                        "[prompt]\nbefore = \"ready?\"\n"),
              0);
  const auto spans = branches(steps);
  REQUIRE(spans.size() == 6);
  CHECK((spans[0].kind == SpanKind::kTravel && spans[0].count == 1));
  CHECK((spans[1].kind == SpanKind::kConditioning && spans[1].count == 4));
  const std::vector<BranchKey> keys = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 1, 1}};
  std::size_t next = 5;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const BranchSpan& span = spans[i + 2];
    CHECK((span.kind == SpanKind::kBranch && span.key == keys[i]));
    CHECK(span.first == next);
    CHECK(span.count == (i % 2 == 0 ? 3 : 2));
    next += span.count;
  }
  CHECK(next == steps.size());
}

TEST_CASE("random reversals lie on the grid, rise and fall in turn and are the same for the same seed") {
  const auto points = [](int seed, int low) {
    return recipe_of("step = 2\n[random]\nseed = " + std::to_string(seed) +
                     "\nreversals = 99\nlow = " + std::to_string(low) + "\nhigh = 60\n")
        .turning_points;
  };
  for (const int low : {0, 10, 56}) {
    const auto drawn = points(3, low);
    REQUIRE(drawn.size() == 103);
    CHECK((drawn[0] == Psi(0) && drawn[1] == Psi(60) && drawn[2] == Psi(0) && drawn.back() == Psi(0)));
    for (std::size_t i = 3; i + 1 < drawn.size(); ++i) {
      CHECK((drawn[i].value() >= low && drawn[i].value() <= 60.0));
      CHECK(std::fmod(drawn[i].value(), 2.0) == 0.0);
      CHECK((drawn[i] > drawn[i - 1]) == (i % 2 == 1));
      CHECK(drawn[i] != drawn[i - 1]);
    }
  }
  CHECK(points(3, 0) == points(3, 0));
  CHECK(points(3, 0) != points(4, 0));
  // Drawn without the library's distributions: the same on every machine.
  const auto first = points(1, 0);
  CHECK((first[3] == Psi(18) && first[4] == Psi(12)));
}

TEST_CASE("overrides replace values and are checked like the file") {
  const Recipe once = read_recipe(kRecipes + "descending.toml", {{"repeats", "1"}, {"conditioning.cycles", "0"}});
  CHECK(once.repeats == 1);
  CHECK(once.conditioning.cycles == 0);
  CHECK_THROWS_AS(read_recipe(kRecipes + "descending.toml", {{"repeat", "1"}}), FileError);
  CHECK_THROWS_AS(read_recipe(kRecipes + "descending.toml", {{"name.x", "1"}}), FileError);
  CHECK_THROWS_AS(read_recipe(kRecipes + "no-such.toml"), FileError);
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
