// Page 1 and the measuring interval by hand: which levels are shown, the longest row within a bound, the largest error.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

// A level at which every taxel has the same U.
LevelUncertainty even_level(double pressure, bool up, double expanded) {
  LevelUncertainty level;
  level.pressure_psi = pressure;
  level.up = up;
  level.expanded_psi.assign(3, expanded);
  level.median.error_psi = 0.01 * pressure;
  level.worst.error_psi = -0.01 * pressure;
  level.median.expanded_psi = 0.5 * expanded;
  level.worst.expanded_psi = expanded;
  level.worst.taxel = 6;
  return level;
}

Uncertainty even_levels(bool up, const std::vector<double>& pressures, const std::vector<double>& expanded) {
  Uncertainty uncertainty;
  for (std::size_t i = 0; i < pressures.size(); ++i)
    uncertainty.levels.push_back(even_level(pressures[i], up, expanded[i]));
  return uncertainty;
}

std::string within_of(const Uncertainty& uncertainty, bool up, double most) {
  return range_within(uncertainty, up, most, PressureUnit::kPsi).value;
}

// Eight levels from 0 to 70 psi both ways, the largest U at 50 psi, decreasing; none going down at 40 psi.
ReportInput brief_input() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = 12;
  input.fit.columns = 4;
  input.evaluation.levels.resize(1);
  input.evaluation.max_error_psi = 3.456;
  input.evaluation.max_error_taxel = 0;
  input.evaluation.max_error_at_psi = 33.33;
  Uncertainty uncertainty;
  for (const bool up : {true, false})
    for (int i = 0; i < 8; ++i)
      if (up || i != 4) uncertainty.levels.push_back(even_level(10.0 * i, up, !up && i == 5 ? 1.5 : 0.5));
  input.uncertainty = uncertainty;
  return input;
}

}  // namespace

TEST_CASE("readings in brief by hand: four levels over the range and the worst one, errors with U, the worst marked") {
  const std::string page = readings_in_brief(brief_input()).value;
  const std::string from = page.substr(page.find("<tbody>", page.find("error and U at some levels, in psi")));
  CHECK(count(from, "<tr>") == 5);
  // Levels 0, 7 / 3, 14 / 3 and 7 of eight. U of the median is half of the worst's.
  check_once(
      from, level_head("0.0", "0.0") + numbers({"0.00 ± 0.25", "0.00 ± 0.50", "0.00 ± 0.25", "0.00 ± 0.50"}) + "</tr>");
  check_once(from, level_head("20.0", "137.9") +
                       numbers({"0.20 ± 0.25", "−0.20 ± 0.50", "0.20 ± 0.25", "−0.20 ± 0.50"}) + "</tr>");
  check_once(from, level_head("40.0", "275.8") + numbers({"0.40 ± 0.25", "−0.40 ± 0.50"}) +
                       "<td class=\"n\" colspan=\"2\">no reading</td></tr>");
  check_once(from, level_head("50.0", "344.7") +
                       numbers({"0.50 ± 0.25", "−0.50 ± 0.50", "0.50 ± 0.75", "▲ −0.5 ± 1.5"}) + "</tr>");
  check_once(from, level_head("70.0", "482.6") +
                       numbers({"0.70 ± 0.25", "−0.70 ± 0.50", "0.70 ± 0.25", "−0.70 ± 0.50"}) + "</tr>");
  check_once(page, "the largest U of all levels, taxel row 1, column 2.");
  CHECK(count(page, "class=\"n\">median taxel</th>") == 2);
  check_once(page, "range of use</th><td>" + psi(0.0, 1) + " to " + psi(70.0, 1) + "</td>");
  // 2 % of 70 psi are 1.4 psi.
  check_once(page, "U of 95 % of the taxels is within 2 % of the full pressure, " + psi(1.4, 2) +
                       ": increasing: " + psi(0.0, 1) + " to " + psi(70.0, 1) + "; decreasing: " + psi(0.0, 1) +
                       " to " + psi(30.0, 1) + "</td>");
}

TEST_CASE("readings in brief by hand: without levels nothing, without U no range but the largest error") {
  ReportInput input = brief_input();
  input.uncertainty->levels.clear();
  check_once(readings_in_brief(input).value, "U was not assessed: no range can be stated");
  input.uncertainty.reset();
  check_once(readings_in_brief(input).value,
             psi(3.456, 2) + ": taxel row 0, column 0, at " + psi(33.33, 1) + ", own run (calibration data)</td>");
  check_none(readings_in_brief(input).value, "measuring interval");
  // Another run counts when its error is larger, not when it is alike.
  Evaluation other = input.evaluation;
  other.max_error_taxel = 7;
  input.held_out = {{"alike", {}, other}, {"larger", {}, other}, {"not known", {}, other}};
  input.held_out[1].evaluation.max_error_psi = 3.5;
  input.held_out[2].evaluation.max_error_psi = kNone;
  check_once(readings_in_brief(input).value, psi(3.5, 2) + ": taxel row 1, column 3, at " + psi(33.33, 1) + ", larger");
  input.held_out.resize(1);
  check_once(readings_in_brief(input).value, ", own run (calibration data)</td>");
  input.evaluation.max_error_taxel = -1;
  check_once(readings_in_brief(input).value, "of one frame and taxel</th><td>not available</td>");
  input.evaluation.levels.clear();
  CHECK(readings_in_brief(input).value.empty());
}

TEST_CASE("the longest row of levels within a bound by hand: the first of two as long, ends alone, none") {
  const std::vector<double> pressures = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0};
  const auto up = [&](const std::vector<double>& expanded) { return even_levels(true, pressures, expanded); };
  const auto row_is = [](double low, double high) { return "increasing: " + psi(low, 1) + " to " + psi(high, 1); };
  CHECK(within_of(up({.1, .3, .1, .1, .1, .3, .1}), true, 0.2) == row_is(20.0, 40.0));
  CHECK(within_of(up({.1, .1, .3, .1, .1, .3, .1}), true, 0.2) == row_is(0.0, 10.0));  // as long as 30 to 40
  CHECK(within_of(up({.3, .1, .1, .3, .1, .1, .1}), true, 0.2) == row_is(40.0, 60.0));
  CHECK(within_of(up({.2, .2, .3, .3, .3, .3, .1}), true, 0.2) == row_is(0.0, 10.0));  // at the bound is within
  CHECK(within_of(up({.3, .3, .3, .1, .3, .3, .3}), true, 0.2) == "increasing: at " + psi(30.0, 1) + " alone");
  CHECK(within_of(up({.3, .3, .3, .1, .3, .3, .1}), true, 0.2) == "increasing: at " + psi(30.0, 1) + " alone");
  CHECK(within_of(up({.3, .3, .3, .3, .3, .3, .3}), true, 0.2) == "increasing: at no level");
  CHECK(within_of(up({.1, .1, .1, .1, .1, .1, .1}), true, 0.2) == row_is(0.0, 60.0));
  // The other branch alone counts.
  CHECK(within_of(up({.1, .1, .1, .1, .1, .1, .1}), false, 0.2) == "decreasing: at no level");
  Uncertainty both = even_levels(true, {0.0, 10.0}, {0.1, 0.1});
  for (const LevelUncertainty& level : even_levels(false, {10.0, 20.0}, {0.1, 0.1}).levels)
    both.levels.push_back(level);
  CHECK(within_of(both, false, 0.2) == "decreasing: " + psi(10.0, 1) + " to " + psi(20.0, 1));
}

TEST_CASE("a level is within a bound when 95 of 100 taxels are, of those that have a model") {
  Uncertainty uncertainty = even_levels(true, {10.0}, {0.1});
  std::vector<double>& expanded = uncertainty.levels[0].expanded_psi;
  expanded.assign(100, 0.1);
  for (std::size_t i = 0; i < 4; ++i) expanded[10 * i] = 0.9;
  expanded.insert(expanded.end(), 50, kNone);
  CHECK(within_of(uncertainty, true, 0.2) == "increasing: at " + psi(10.0, 1) + " alone");
  expanded[5] = 0.9;
  CHECK(within_of(uncertainty, true, 0.2) == "increasing: at no level");
}
