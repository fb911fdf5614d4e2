// The method in words: sweeps, levels, waiting times, conditioning, from the recipe and what was set.
#include "bench/reporting/method_words.h"

#include <catch2/catch.hpp>

#include "analysis/pressure_unit.h"
#include "bench/config/config.h"
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

TEST_CASE("method in words: production has its sweeps, levels, turns, dwell and conditioning, as was set") {
  const std::string toml = shipped_text("production");
  // Eight sweeps: 0 60 0 40 0 60 20 60 0.
  CHECK(method_words(run_of(toml)) ==
        std::vector<std::string>{
            "3 repeats of 8 sweeps; a level every 4 psi, from 0 to 60 to 0 to 40 to 0 to 60 to 20 to 60 to 0 psi; "
            "waiting "
            "time (dwell) 1 s from pressure or force in band to the frame; before it 2 to 4 cycles to 60 psi without "
            "frames, until two differ by less than 0.5 % of full scale"});
  const std::string set = method_words(run_of(toml, R"([{"key":"recipe.dwell_s","value":"2.5"},)"
                                                    R"({"key":"recipe.repeats","value":"1"}])"))
                              .front();
  CHECK_THAT(set, Catch::StartsWith("1 repeat of 8 sweeps;") && Catch::Contains("(dwell) 2.5 s from"));
  // On a page in kPa, 60 psi = 413.7 kPa and 4 psi = 27.58 kPa, psi behind.
  const std::string page =
      analysis::PressureUnit(analysis::PressureUnit::kKilopascal).both_in_text(method_words(run_of(toml)).front());
  CHECK_THAT(page, Catch::Contains("a level every 27.58 kPa (4 psi), from 0 to 413.7 to 0 to 275.8 to 0 to 413.7 to "
                                   "137.9 to 413.7 to 0 kPa (0 to 60 to 0 to 40 to 0 to 60 to 20 to 60 to 0 psi);") &&
                       Catch::Contains("cycles to 413.7 kPa (60 psi) without frames"));
}

TEST_CASE(
    "method in words: ramps and dwell times that change from repeat to repeat, presses, warm-up, what is unreadable") {
  CHECK_THAT(
      method_words(run_of(shipped_text("rate-ramp"))).front(),
      Catch::StartsWith("3 repeats of 2 sweeps; a level every 4 psi, from 0 to 60 to 0 psi; on a ramp of 0.5 psi/s, "
                        "2 psi/s, 8 psi/s, one a repeat in turn, frames as it passes the levels; before it 3 cycles "
                        "to 60 psi without frames"));
  CHECK_THAT(
      method_words(run_of(shipped_text("point-grid"))).front(),
      Catch::Contains("; point at 25 places, forces of 3, 6 N; waiting time (dwell) 1 s from pressure or force in "
                      "band to the frame; "));
  const std::string warmed =
      "schema = 1\nname = \"w\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\ndwell_s = [1.0, "
      "4.0]\n[warm_up]\nat_most_s = 600\ndrift_percent_per_min = 0.2\n";
  CHECK(
      method_words(run_of(warmed)).front() ==
      "2 repeats of 2 sweeps; a level every 5 psi, from 0 to 10 to 0 psi; waiting time (dwell) 1, 4 s from pressure or "
      "force in band to the frame, one a repeat in turn; no conditioning before it; before the run a wait of at most "
      "600 s until the unloaded output drifts by less than 0.2 % of the range a minute");
  CHECK(method_words(run_of("no recipe")) == std::vector<std::string>{""});
}
