// As found and as left by hand: every number of both tables, the marks of each level, the two charts, the verdicts.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

LevelFigures found_level(double pressure, double distance, double std_up, double std_down, double raw_distance = 0.9,
                         double raw_up = 0.9, double raw_down = 0.9) {
  LevelFigures level;
  level.pressure_psi = pressure;
  level.comp_distance = distance;
  level.comp_std_up = std_up;
  level.comp_std_down = std_down;
  level.raw_distance = raw_distance;
  level.raw_std_up = raw_up;
  level.raw_std_down = raw_down;
  return level;
}

Evaluation found_errors(double step) {
  Evaluation e;
  e.full_scale_v = 3.4567;
  e.full_scale_psi = 60.04;
  e.mean_error_psi = 0.1114 + step;
  e.mean_error_observable_psi = 0.2224 + step;
  e.max_error_psi = 3.333 + step;
  e.worst_taxel_mean_error_psi = 0.4444 + step;
  e.raw_distance = 0.1666;
  e.comp_distance_of_mean = 0.0555 + step;
  e.comp_distance = 0.0666 + step;
  return e;
}

// Three levels, of which the second is worse than the indication; no earlier models, no other run.
ReportInput left_alone() {
  ReportInput input;
  input.run.run = 12;
  input.run.origin = "hardware";
  input.unit = PressureUnit::kPsi;
  input.evaluation = found_errors(0.0);
  input.evaluation.levels = {found_level(0.0, 0.0123, 0.0234, 0.0345, 0.1234, 0.2345, 0.3456),
                             found_level(20.0, 0.3, 0.4, 0.5, 0.2222, 0.9, 0.9),
                             found_level(40.0, 0.04, 0.05, 0.06, 0.4, 0.9, 0.9)};
  input.evaluation.levels[1].made_worse = true;
  input.more.straight = {7.777, 8.88, 9.999};
  return input;
}

// The same with earlier models, whose levels lie 0.05, 0.049 and 0 psi off, and two other runs.
ReportInput with_earlier_models() {
  ReportInput input = left_alone();
  input.more.previous = AsFound{"earlier.json", found_errors(0.001), 253, {}, ""};
  input.more.previous->evaluation.levels = {found_level(0.05, 0.7, 0.7, 0.7), found_level(20.049, 0.3, 0.0712, 0.0823),
                                            found_level(40.0, 0.0399, 0.0734, 0.0845)};
  input.held_out = {{"a later day", input.run, found_errors(0.002)}, {"another", input.run, found_errors(0.003)}};
  input.held_out[0].evaluation.levels = {found_level(0.0, 0.0912, 0.1, 0.1), found_level(40.0, 0.0934, 0.1, 0.1)};
  for (LevelFigures& own : input.held_out[0].evaluation.levels) own.made_worse = true;
  return input;
}

db::VerdictRecord found_verdict(const char* criterion, double value, const char* verdict) {
  return {12, 1, criterion, "array", value, 0.015, "FS", "simple", verdict, "", "", 0};
}

LineChart found_chart(const char* title, std::vector<Series> series) {
  return {.title = title,
          .x_label = "gauge pressure",
          .y_label = "hysteresis in % FS",
          .series = std::move(series),
          .width = 335,
          .height = 265,
          .y_from_zero = true};
}

}  // namespace

TEST_CASE("as found by hand: every figure of indication, earlier models, own models and the first other run") {
  const std::string page = as_found_section(with_earlier_models()).value;
  check_once(page, row("mean absolute error", {psi(7.777, 2), psi(0.1124, 3), psi(0.1114, 3), psi(0.1134, 3)}));
  check_once(page,
             row("the same without flat samples", {"not assessed", psi(0.2234, 3), psi(0.2224, 3), psi(0.2244, 3)}));
  check_once(page, row("maximum absolute error", {psi(8.88, 1), psi(3.334, 2), psi(3.333, 2), psi(3.335, 2)}));
  check_once(page, row("mean absolute error of the worst taxel",
                       {psi(9.999, 2), psi(0.4454, 3), psi(0.4444, 3), psi(0.4464, 3)}));
  check_once(page, row("hysteresis of the mean of all taxels, % FS", {"16.66", "5.65", "5.55", "5.75"}));
  // The mean of 12.34, 22.22 and 40 % is 24.85 %.
  check_once(page, row("hysteresis, mean over taxels, % FS", {"24.85", "6.76", "6.66", "6.86"}));
  check_once(page, row("levels with more hysteresis than the indication", {"–", "0 of 3", "1 of 3", "2 of 2"}));
  check_once(page, "class=\"n\">as left, a later day</th></tr>");
  check_once(page, "models used before, earlier.json (253 taxels). As left:");
  check_once(page, "FS of the indication: 3.457 V, the highest");
  check_once(page, "indication: " + psi(60.04, 1) + ", the full pressure");
}

TEST_CASE("as found by hand: without earlier models or another run their columns say so") {
  const std::string page = as_found_section(left_alone()).value;
  check_once(page, row("mean absolute error", {psi(7.777, 2), "not assessed", psi(0.1114, 3), "not assessed"}));
  check_once(page,
             row("levels with more hysteresis than the indication", {"–", "not assessed", "1 of 3", "not assessed"}));
  check_once(page, "class=\"n\">as left, held-out run</th></tr>");
  check_once(page, "no earlier models were named");
  check_none(page, "models used before");
  check_once(page, level_head("40.0", "275.8") +
                       numbers({"40.00", "–", "4.00", "90.00", "–", "5.00", "90.00", "–", "6.00"}) +
                       "<td>no worse</td></tr>");
  ReportInput none = left_alone();
  none.evaluation.levels.clear();
  check_once(as_found_section(none).value, "<p>not available</p>");
  check_none(as_found_section(none).value, "<table");
}

TEST_CASE("as found by hand: each level beside the earlier one within 0.05 psi, and what is worse than which") {
  ReportInput input = with_earlier_models();
  const std::string worse = "<span class=\"worse\"><span class=\"sign\">▲</span> worse than ";
  std::string page = as_found_section(input).value;
  // 0.05 psi off is another level.
  check_once(page, level_head("0.0", "0.0") +
                       numbers({"12.34", "not available", "1.23", "23.45", "not available", "2.34", "34.56",
                                "not available", "3.45"}) +
                       "<td>no worse</td></tr>");
  // Alike (0.3) is not worse than as found.
  check_once(page, level_head("20.0", "137.9") +
                       numbers({"22.22", "30.00", "30.00", "90.00", "7.12", "40.00", "90.00", "8.23", "50.00"}) +
                       "<td>" + worse + "the indication</span></td></tr>");
  check_once(page, level_head("40.0", "275.8") +
                       numbers({"40.00", "3.99", "4.00", "90.00", "7.34", "5.00", "90.00", "8.45", "6.00"}) + "<td>" +
                       worse + "as found</span></td></tr>");
  CHECK(count(page, "<th scope=\"col\" class=\"n\">indic.</th><th scope=\"col\" class=\"n\">found</th>") == 3);
  CHECK(count(page, " rowspan=\"2\" class=\"n\">") == 2);
  input.more.previous->evaluation.levels[1].comp_distance = 0.29;
  page = as_found_section(input).value;
  check_once(page, "<td>" + worse + "the indication</span>; " + worse + "as found</span></td></tr>");
}

TEST_CASE("as found by hand: the charts hold indication and corrected indications in per cent, and the latter alone") {
  const Series indication{"indication", {0.0, 20.0, 40.0}, {12.34, 22.22, 40.0}, 0},
      found{"as found", {0.05, 20.049, 40.0}, {70.0, 30.0, 3.99}, 1},
      own{"as left, own run", {0.0, 20.0, 40.0}, {1.23, 30.0, 4.0}, 2},
      held{"as left, held out", {0.0, 40.0}, {9.12, 9.34}, 3};
  const char* const all = "Hysteresis per level: indication, as found, as left";
  const char* const alone = "The same of the corrected indication alone, on a scale of its own";
  std::string page = as_found_section(with_earlier_models()).value;
  check_along(page, found_chart(all, {indication, found, own, held}));
  check_along(page, found_chart(alone, {found, own, held}));
  page = as_found_section(left_alone()).value;
  check_along(page, found_chart(all, {indication, own}));
  check_along(page, found_chart(alone, {own}));
}

TEST_CASE("as found by hand: the verdicts before and after, with value, limit and doubt") {
  ReportInput input = with_earlier_models();
  check_none(as_found_section(input).value, "As found against the tolerance limits");
  input.more.previous->verdicts = {found_verdict("distance_of_mean", 0.01614, "fail"),
                                   found_verdict("mismatch", 0.01414, "pass")};
  std::string page = as_found_section(input).value;
  const std::string fail = "<span class=\"fail\"><span class=\"sign\">✗</span> fail</span>",
                    pass = "<span class=\"pass\"><span class=\"sign\">✓</span> pass</span>";
  check_once(page, "<p>As found: " + fail + ". As left: no verdict.</p>");
  check_once(page,
             "<td>array</td>" + numbers({"1.61\u00A0%\u00A0FS", "1.50\u00A0%\u00A0FS"}) + "<td>" + fail + "</td></tr>");
  check_once(page,
             "<td>array</td>" + numbers({"1.41\u00A0%\u00A0FS", "1.50\u00A0%\u00A0FS"}) + "<td>" + pass + "</td></tr>");
  check_none(page, "<p class=\"fail\">");
  input.verdicts = {found_verdict("distance_of_mean", 0.01, "pass")};
  input.judgement.not_assessed = {{"creep", "no run"}};
  input.more.previous->doubt = "Measurements since May are in doubt.";
  page = as_found_section(input).value;
  check_once(page, "As left: " + pass + ", under repeatability conditions only.</p>");
  check_once(page, "<p class=\"fail\"><span class=\"sign\">✗</span> Measurements since May are in doubt.</p>");
  input.run.origin = "simulated";
  CHECK(count(as_found_section(input).value, "</span> simulated ") == 4);
  for (db::VerdictRecord& verdict : input.more.previous->verdicts) verdict.verdict = "report only";
  check_none(as_found_section(input).value, "As found against the tolerance limits");
}
