// Times of compiled steps by the model, against times worked out by hand.
#include <catch2/catch.hpp>

#include "sequences/estimate.h"
#include "sequences/recipe.h"

using namespace tactbench::sequences;

TEST_CASE("times by hand: way over the slower of ramp and chamber, then settling, dwell and frame") {
  // Dwell 3 s, frame 0.5 s, settling 1 s (0.7 to 2 s). Rises at 10 psi/s, falls at 5: 0, 20, 0 takes 2 s and 4 s.
  TimeModel model;
  model.rise_psi_per_s = 10.0;
  model.fall_psi_per_s = 5.0;
  model.settle_s = 1.0;
  model.frame_s = 0.5;
  const auto times_of = [&](const std::string& ramp) {
    const std::vector<Recipe> recipes = {parse_recipe(TomlDocument::from_text(
        "schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 20\ndwell_s = 3\n" + ramp,
        "t.toml"))};
    return step_times(recipes, compile(recipes), model);
  };
  const auto check_likely = [](const std::vector<StepTime>& times, const std::vector<double>& seconds) {
    REQUIRE(times.size() == seconds.size());
    for (std::size_t i = 0; i < times.size(); ++i) CHECK(times[i].likely_s == Approx(seconds[i]));
  };
  check_likely(times_of(""), {4.5, 6.5, 8.5});
  CHECK(times_of("")[1].low_s == Approx(6.2));
  CHECK(times_of("")[1].high_s == Approx(7.5));
  check_likely(times_of("ramp_psi_per_s = 1\n"), {4.5, 24.5, 24.5});  // slower than the chamber either way
  check_likely(times_of("ramp_psi_per_s = 8\n"), {4.5, 7.0, 8.5});    // slower up, faster down
  check_likely(times_of("ramp_psi_per_s = 40\n"), {4.5, 6.5, 8.5});   // the chamber cannot
}
