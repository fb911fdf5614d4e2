#include "sequences/estimate.h"

#include <catch2/catch.hpp>

#include "tests/sequences/recipe_text.h"

using namespace tactbench::sequences;

namespace {

TimeModel model_of() {
  TimeModel model;
  model.rise_psi_per_s = 4.0;
  model.fall_psi_per_s = 2.0;
  model.settle_s = 10.0;
  model.frame_s = 0.25;
  return model;
}

}  // namespace

TEST_CASE("a level takes its ramp by the chamber's rise or fall, 0.7 to 2 times the settling, its dwell and a frame") {
  const std::vector<Recipe> recipes = {recipe_of("turning_points = [0, 0.5, 0]\nstep = 0.5\ndwell_s = 3\n")};
  const auto times = step_times(recipes, compile(recipes), model_of());
  REQUIRE(times.size() == 3);
  const std::vector<double> ramps_s = {0.0, 0.5 / 4.0, 0.5 / 2.0};  // a short way up is a rise, too
  for (std::size_t i = 0; i < times.size(); ++i) {
    CHECK(times[i].low_s == Approx(ramps_s[i] + 3.0 + 7.0 + 0.25));
    CHECK(times[i].likely_s == Approx(ramps_s[i] + 3.0 + 10.0 + 0.25));
    CHECK(times[i].high_s == Approx(ramps_s[i] + 3.0 + 20.0 + 0.25));
  }
}

TEST_CASE("a ramp slower than the chamber's takes its own time, a faster one the chamber's") {
  const auto likely = [](const std::string& rate) {
    const std::vector<Recipe> recipes = {
        recipe_of("turning_points = [0, 8, 0]\nstep = 8\nramp_psi_per_s = " + rate + "\n")};
    return step_times(recipes, compile(recipes), model_of());
  };
  const auto slow = likely("1"), fast = likely("100");
  CHECK(slow[1].likely_s - slow[0].likely_s == Approx(8.0 / 1.0));
  CHECK(slow[2].likely_s - slow[0].likely_s == Approx(8.0 / 1.0));
  CHECK(fast[1].likely_s - fast[0].likely_s == Approx(8.0 / 4.0));
  CHECK(fast[2].likely_s - fast[0].likely_s == Approx(8.0 / 2.0));
}

TEST_CASE("an estimate sums the steps, and stores each frame's blob and 220 bytes of row") {
  const std::vector<Recipe> recipes = {recipe_of("turning_points = [0, 4, 0]\nstep = 2\nrepeats = 2\n")};
  const auto steps = compile(recipes);
  const Estimate all = estimate(recipes, steps, model_of(), 1000.0);
  CHECK(all.steps == static_cast<int>(steps.size()));
  CHECK(all.frames == 10);
  CHECK(all.bytes == 10 * 1220.0);
}
