// The time of each kind of step by the model, computed by hand, and the sums of an estimate.
#include <catch2/catch.hpp>

#include "sequences/estimate.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

// Contact 20 N/mm at 0.05 mm/s is 1 N/s; 5 mm of clearance at 0.5 mm/s take 10 s.
TimeModel slow_bench() {
  TimeModel model;
  model.rise_psi_per_s = 4.0;
  model.fall_psi_per_s = 2.0;
  model.settle_s = 10.0;
  model.frame_s = 0.25;
  model.prompt_s = 30.0;
  model.home_s = 20.0;
  model.tare_s = 2.0;
  model.move_s = 6.0;
  model.stiffness_n_per_mm = 20.0;
  return model;
}

Recipe touch(const std::string& press = {}) {
  return press_of("forces_n = [2, 6]\ncontact_n = 0.5\npositions_mm = [[1, 1]]\n" + press, "dwell_s = 3\n");
}

void check_times(const std::vector<StepTime>& times, const std::vector<StepTime>& wanted) {
  REQUIRE(times.size() == wanted.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    INFO("step " << i);
    CHECK(times[i].low_s == Approx(wanted[i].low_s).margin(1e-12));
    CHECK(times[i].likely_s == Approx(wanted[i].likely_s).margin(1e-12));
    CHECK(times[i].high_s == Approx(wanted[i].high_s).margin(1e-12));
  }
}

std::vector<StepTime> times_of(const std::vector<Recipe>& recipes) {
  return step_times(recipes, compile(recipes), slow_bench());
}

}  // namespace

TEST_CASE("estimate: a press takes the time between its forces, with half and twice the contact's stiffness") {
  check_times(times_of({touch()}), {{10, 20, 40},         // home
                                    {1, 2, 4},            // tare
                                    {3, 6, 12},           // move
                                    {5, 10, 20},          // approach, to 0.5 N
                                    {4.0, 4.75, 6.25},    // to 2 N: 1.5 s, dwell 3 s, frame 0.25 s
                                    {5.25, 7.25, 11.25},  // to 6 N: 4 s
                                    {5.25, 7.25, 11.25},  // back to 2 N
                                    {5, 10, 20},          // retract
                                    {1, 2, 4}});          // tare
  Step press;                                             // alone, it starts from no force
  press.kind = StepKind::kPress;
  press.force_n = 2.0;
  press.dwell_s = 1.0;
  check_times(step_times({touch()}, {press}, slow_bench()), {{2.25, 3.25, 5.25}});
}

TEST_CASE("estimate: a prompt takes half to twice its time, a held frame its interval, passing levels no settling") {
  const Recipe held = recipe_of(
      "turning_points = [0]\nstep = 2\nframes_per_level = 2\nframe_interval_s = 5\n[prompt]\nbefore = \"?\"\n");
  check_times(times_of({held}), {{15, 30, 60}, {9.25, 12.25, 22.25}, {5.25, 5.25, 5.25}});
  const Recipe passing = recipe_of("turning_points = [0, 2]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = 0.5\n");
  check_times(times_of({passing}), {{7.25, 10.25, 20.25}, {4.25, 4.25, 4.25}});
}

TEST_CASE("estimate: conditioning cycles that may be skipped are not in the shortest time") {
  const std::string cycles =
      "turning_points = [0, 0.5]\nstep = 0.5\nrepeats = 4\n[conditioning]\ncycles = 4\n"
      "least = 2\npeak = 8\n";
  const auto always = times_of({recipe_of(cycles)});
  const auto perhaps = times_of({recipe_of(cycles + "change_percent = 0.5\n")});
  REQUIRE(perhaps.size() == 16);  // 4 cycles of 2, 4 repeats of 2
  REQUIRE(always.size() == 16);
  for (std::size_t i = 0; i < perhaps.size(); ++i) {
    INFO("step " << i);
    CHECK(perhaps[i].low_s == (i >= 4 && i < 8 ? 0.0 : always[i].low_s));
    CHECK(always[i].low_s > 0.0);
    CHECK(perhaps[i].likely_s == always[i].likely_s);
    CHECK(perhaps[i].high_s == always[i].high_s);
  }
  CHECK(always[0].likely_s == Approx(8.0 / 4.0 + 2.0 + 10.0));
  CHECK(always[1].likely_s == Approx(8.0 / 2.0 + 2.0 + 10.0));
}

TEST_CASE("estimate: twice the contact stiffness at twice the servo speed takes a quarter of the time") {
  TimeModel stiff = slow_bench();
  stiff.stiffness_n_per_mm = 40.0;
  const std::vector<Recipe> recipes = {touch("servo_mm_per_s = 0.1\n")};
  const std::vector<StepTime> times = step_times(recipes, compile(recipes), stiff);
  check_times({times.begin() + 5, times.begin() + 6}, {{3.75, 4.25, 5.25}});  // from 2 to 6 N: 1 s instead of 4 s
}

TEST_CASE("estimate: a recipe's first step has none, half and all of the warm-up as low, likely and high time") {
  const Recipe warm = recipe_of("turning_points = [0, 4]\nstep = 4\n[warm_up]\nat_most_s = 100\n");
  const std::vector<StepTime> cold = times_of({recipe_of("turning_points = [0, 4]\nstep = 4\n")});
  const std::vector<StepTime> times = times_of({warm, warm});
  REQUIRE(times.size() == 4);
  // The second recipe starts from the 4 psi of the first: 2 s down to its first level.
  for (const std::size_t i : {0U, 2U}) {
    const double way_s = i == 0 ? 0.0 : 2.0;
    CHECK(times[i].low_s == Approx(cold[0].low_s + way_s));
    CHECK(times[i].likely_s == Approx(cold[0].likely_s + way_s + 50.0));
    CHECK(times[i].high_s == Approx(cold[0].high_s + way_s + 100.0));
    CHECK(times[i + 1].high_s == Approx(cold[1].high_s));
  }
}

TEST_CASE("estimate: the total is the sum of the times of all steps") {
  const std::vector<Recipe> recipes = {touch()};
  const Estimate all = estimate(recipes, compile(recipes), slow_bench(), 100.0);
  CHECK((all.steps == 9 && all.frames == 3));
  CHECK(all.time.low_s == Approx(10 + 1 + 3 + 5 + 4.0 + 5.25 + 5.25 + 5 + 1));
  CHECK(all.time.likely_s == Approx(20 + 2 + 6 + 10 + 4.75 + 7.25 + 7.25 + 10 + 2));
  CHECK(all.time.high_s == Approx(40 + 4 + 12 + 20 + 6.25 + 11.25 + 11.25 + 20 + 4));
  CHECK(all.bytes == 3 * 320.0);
}

TEST_CASE("estimate: a level takes its ramp, 0.7 to 2 times the settling, its dwell and a frame") {
  const std::vector<Recipe> recipes = {recipe_of("turning_points = [0, 0.5, 0]\nstep = 0.5\ndwell_s = 3\n")};
  const auto times = step_times(recipes, compile(recipes), slow_bench());
  REQUIRE(times.size() == 3);
  const std::vector<double> ramps_s = {0.0, 0.5 / 4.0, 0.5 / 2.0};  // a short way up is a rise, too
  for (std::size_t i = 0; i < times.size(); ++i) {
    CHECK(times[i].low_s == Approx(ramps_s[i] + 3.0 + 7.0 + 0.25));
    CHECK(times[i].likely_s == Approx(ramps_s[i] + 3.0 + 10.0 + 0.25));
    CHECK(times[i].high_s == Approx(ramps_s[i] + 3.0 + 20.0 + 0.25));
  }
}

TEST_CASE("estimate: a ramp slower than the chamber's takes its own time, a faster one the chamber's") {
  const auto likely = [](const std::string& rate) {
    const std::vector<Recipe> recipes = {
        recipe_of("turning_points = [0, 8, 0]\nstep = 8\nramp_psi_per_s = " + rate + "\n")};
    return step_times(recipes, compile(recipes), slow_bench());
  };
  const auto slow = likely("1"), fast = likely("100");
  CHECK(slow[1].likely_s - slow[0].likely_s == Approx(8.0 / 1.0));
  CHECK(slow[2].likely_s - slow[0].likely_s == Approx(8.0 / 1.0));
  CHECK(fast[1].likely_s - fast[0].likely_s == Approx(8.0 / 4.0));
  CHECK(fast[2].likely_s - fast[0].likely_s == Approx(8.0 / 2.0));
}
