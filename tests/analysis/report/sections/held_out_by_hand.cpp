// The same models on other runs, by hand: every figure of a column, and how many columns a table has.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

// Figures that differ in the digit after the last one printed, by `step` from column to column.
Evaluation held_figures(double step, int frames) {
  Evaluation e;
  e.raw_distance = 0.11114 + step;
  e.comp_distance_of_mean = 0.01224 + step;
  e.comp_distance = 0.01334 + step;
  e.comp_distance_observable = 0.01444 + step;
  e.worst_taxel_distance = 0.01554 + step;
  e.worst_taxel_distance_observable = 0.01664 + step;
  e.flat_share = 0.0774 + step;
  e.mean_error_psi = 0.8884 + step;
  e.mean_error_observable_psi = 0.7774 + step;
  e.worst_taxel_mean_error_psi = 1.6664 + step;
  e.full_scale_psi = 60.04;
  e.frames = frames;
  e.levels.resize(3);
  return e;
}

db::RunRecord held_run(std::int64_t number, std::vector<const char*> recipes) {
  db::RunRecord run;
  run.run = number;
  run.started_utc = "2024-05-06T07:08:09Z";
  for (const char* recipe : recipes) run.sequences.push_back({0, recipe, "", "", 1, 1});
  return run;
}

ReportInput held_out_runs(int number) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run = held_run(12, {"descending", "ascending"});
  input.evaluation = held_figures(0.0, 3310);
  input.evaluation.levels[1].made_worse = true;
  for (int i = 0; i < number; ++i) {
    input.held_out.push_back({"run " + std::to_string(i), held_run(13 + i, {}), held_figures(0.01, 662)});
    for (LevelFigures& level : input.held_out.back().evaluation.levels) level.made_worse = true;
    input.held_out.back().evaluation.levels[0].made_worse = false;
  }
  return input;
}

}  // namespace

TEST_CASE("held-out runs by hand: every figure of the own run beside that of another") {
  const std::string page = held_out_section(held_out_runs(1)).value;
  check_once(page, "<caption>The models on this and other runs</caption>");
  check_once(page, "class=\"n\">own run (calibration data)</th><th scope=\"col\" class=\"n\">run 0</th></tr>");
  check_once(page, row("run", {"12", "13"}));
  check_once(page, row("recipes: the trajectories that its errors hold for", {"descending, ascending", "not stated"}));
  check_once(page, row("started (UTC)", {"2024-05-06 07:08:09Z", "2024-05-06 07:08:09Z"}));
  check_once(page, row("frames evaluated", {"3310", "662"}));
  check_once(page, row("indication: hysteresis of the mean taxel, % FS", {"11.11", "12.11"}));
  check_once(page, row("corrected: hysteresis of the mean of all pressures, % FS", {"1.22", "2.22"}));
  check_once(page, row("corrected: hysteresis, mean over taxels, % FS", {"1.33", "2.33"}));
  check_once(page, row("the same without flagged levels, % FS", {"1.44", "2.44"}));
  check_once(page, row("corrected: hysteresis, worst taxel, % FS", {"1.55", "2.55"}));
  check_once(page, row("the same without flagged levels, % FS", {"1.66", "2.66"}));
  check_once(page, row("flagged pairs of taxel and level, %", {"7.7", "8.7"}));
  check_once(page, row("mean absolute error", {psi(0.8884, 3), psi(0.8984, 3)}));
  check_once(page, row("the same without flat samples", {psi(0.7774, 3), psi(0.7874, 3)}));
  check_once(page, row("mean absolute error of the worst taxel", {psi(1.6664, 3), psi(1.6764, 3)}));
  check_once(page, row("levels with more hysteresis than the indication", {"1 of 3", "2 of 3"}));
  check_once(page, "The models were made from run 12 only,");
  check_once(page, "full pressure, " + psi(60.04, 1) + ".");
  check_none(page, "not assessed");
  check_none(page, "continued");
}

TEST_CASE("held-out runs by hand: four columns a table, the fifth begins another") {
  const auto tables = [](int others) { return count(held_out_section(held_out_runs(others)).value, "<table>"); };
  CHECK(tables(0) == 1);
  CHECK(tables(3) == 1);
  CHECK(tables(4) == 2);
  CHECK(tables(7) == 2);
  CHECK(tables(8) == 3);
  const std::string page = held_out_section(held_out_runs(5)).value;
  check_once(page, "<caption>The models on this and other runs</caption>");
  check_once(page, "<caption>The models on other runs, continued</caption>");
  check_once(page, row("run", {"12", "13", "14", "15"}));
  check_once(page, row("run", {"16", "17"}));
  check_once(held_out_section(held_out_runs(0)).value, "not assessed: no other run of this sensor was given");
}
