#include <catch2/catch.hpp>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

namespace {

Recipe rules_of(const std::string& rules) {
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nunit = \"kPa\"\nturning_points = [0, 60]\nstep = 2\n" + rules, "r.toml"));
}

}  // namespace

TEST_CASE("the rules of a run are read") {
  const Recipe given = rules_of(
      "rest_restart_s = 600\n"
      "[conditioning]\ncycles = 6\nleast = 2\nchange_percent = 0.5\npeak = 100\n"
      "[warm_up]\ndrift_percent_per_min = 0.05\nat_most_s = 900\n"
      "[guard]\ntolerance_psi = 0.3\nredo = 1\non_broken = \"flag\"\n"
      "[dwell]\ntolerance_s = 0.1\n"
      "[retry]\nframe = 3\nverdict = \"any\"\n"
      "[timeout]\nstep_s = 40\n"
      "[limits]\nleast_response_v = 0.2\nmost_dead_taxels = 8\n"
      "[prompt]\nbefore = \"ready?\"\n"
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 5\ntimeout_s = 60\n"
      "[[suspend]]\nquantity = \"temperature_c\"\ntrip_above = 30\nresume_below = 28\n");
  CHECK(given.rest_restart_s == 600.0);
  CHECK((given.conditioning.cycles == 6 && given.conditioning.least == 2 && given.conditioning.change_percent == 0.5));
  CHECK(given.conditioning.peak.value() == Approx(14.503773773));  // of the recipe's unit
  CHECK((given.warm_up.drift_percent_per_min == 0.05 && given.warm_up.at_most_s == 900.0));
  // The guard's tolerance is in psi whatever the recipe's unit.
  CHECK((given.guard.tolerance.value() == 0.3 && given.guard.redo == 1 && !given.guard.fail_when_broken));
  CHECK(given.dwell_tolerance_s == 0.1);
  CHECK((given.retry.frame == 3 && given.retry.any_passes));
  CHECK(given.step_timeout_s == 40.0);
  CHECK((given.limits.least_response_v == 0.2 && given.limits.most_dead_taxels == 8));
  REQUIRE(given.suspend.size() == 2);
  CHECK((given.suspend[0].below && given.suspend[0].trip == 6.0 && given.suspend[0].resume == 6.5));
  CHECK((given.suspend[0].hold_s == 5.0 && given.suspend[0].timeout_s == 60.0));
  CHECK((!given.suspend[1].below && given.suspend[1].quantity == "temperature_c"));
  const auto steps = compile(given, 2);
  CHECK((steps[0].kind == StepKind::kPrompt && steps[0].text == "ready?" && steps[0].sequence == 2));
}
