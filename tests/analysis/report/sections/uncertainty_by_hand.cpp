// The section on uncertainty by hand: budgets row by row, levels, measuring intervals, the chart, conditions of use.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

Contribution contribution_of(UncertaintySource source, double width, double divisor, double sensitivity, double u,
                             double dof) {
  Contribution row;
  row.source = source;
  row.width = width;
  row.divisor = divisor;
  row.sensitivity = sensitivity;
  row.u_psi = u;
  row.dof = dof;
  return row;
}

// 0.03 psi of the model and 0.04 psi of noise: 0.05 psi together.
Budget budget_by_hand(int taxel, double error) {
  Budget budget;
  budget.taxel = taxel;
  budget.pressure_psi = 30.04;
  budget.up = false;
  budget.error_psi = error;
  budget.readings = 1;
  budget.contributions = {contribution_of(UncertaintySource::kNoise, 0.0041234, 1.0, 9.7014, 0.04, 250.7),
                          contribution_of(UncertaintySource::kModel, 0.051964, 1.73214, 1.00012, 0.03, 4.9)};
  budget.combined_psi = 0.05;
  budget.dof = 33.6;
  budget.factor = 2.075;
  budget.expanded_psi = 0.1044;
  return budget;
}

LevelUncertainty level_by_hand(double pressure, bool up, double expanded) {
  LevelUncertainty level;
  level.pressure_psi = pressure;
  level.up = up;
  level.median = budget_by_hand(4, 0.1234);
  level.median.readings = 6;
  level.median.expanded_psi = expanded;
  level.worst = budget_by_hand(5, -0.2345);
  level.worst.expanded_psi = 2.0 * expanded;
  level.expanded_psi = {expanded, 2.0 * expanded};
  return level;
}

ReportInput assessed_by_hand() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = 2;
  input.fit.columns = 3;
  input.uncertainty.emplace();
  Uncertainty& u = *input.uncertainty;
  u.levels = {level_by_hand(0.0, true, 0.1), level_by_hand(30.0, true, 0.2), level_by_hand(60.0, true, 0.7),
              level_by_hand(30.0, false, 0.25), level_by_hand(0.0, false, 0.3)};
  u.levels[1].not_linear = 1;
  u.chosen = 3;
  u.levels[3].median = budget_by_hand(4, 0.1234);
  u.levels[3].worst = budget_by_hand(5, -0.2345);
  u.missing[static_cast<std::size_t>(UncertaintySource::kUniformity)] = "no runs above 40 psi";
  u.from[static_cast<std::size_t>(UncertaintySource::kMounting)] = "runs 3 to 6 at 40 psi";
  return input;
}

std::string budget_of(const std::string& page, const char* which) {
  const std::size_t from = page.find(std::string("Budget of the ") + which + " taxel");
  REQUIRE(from != std::string::npos);
  return page.substr(from, page.find("<div", from) - from);
}

}  // namespace

TEST_CASE("a budget by hand: widths, divisors, sensitivities, contributions, degrees and shares, then U") {
  const ReportInput input = assessed_by_hand();
  const std::string page = uncertainty_section(input).value, median = budget_of(page, "median");
  CHECK(median.rfind("Budget of the median taxel (row 1, column 1) at " + psi(30.04, 1) + ", decreasing</caption>",
                     0) == 0);
  // 4.1234 mV of noise at 9.7014 psi a volt; 16 / 25 and 9 / 25 of the variance.
  check_once(median, "<th scope=\"row\">short-term repeatability (noise)</th><td>A</td>" +
                         numbers({"0.00", "4.12 mV"}) + "<td>s</td><td>normal</td>" +
                         numbers({"1", "0.0097 psi/mV", "0.040", "250", "64.0"}) + "</tr>");
  check_once(median, "<th scope=\"row\">lack of fit, corrected</th><td>A</td>" + numbers({"0.12", "0.052 psi"}) +
                         "<td>u of the mean</td><td>Student</td>" + numbers({"1.73", "1", "0.030", "4", "36.0"}) +
                         "</tr>");
  check_once(median,
             "<th scope=\"row\">uniformity of the pressure in the chamber</th><td>A</td><td colspan=\"9\">not "
             "assessed</td></tr>");
  CHECK(count(median, "<td colspan=\"9\">not assessed</td>") == 1);
  check_once(median, "effective degrees of freedom</td>" + numbers({"0.050", "33", "100.0"}) + "</tr>");
  check_once(median, "U = 2.08 u_c(y)</td><td class=\"n\" colspan=\"3\">0.10\u00A0psi (0.72\u00A0kPa)</td></tr>");
  check_once(median, "the mean of 1 reading less");
  check_once(median, "is then off by 0 ± 0.10\u00A0psi (0.72\u00A0kPa) (k = 2.08).");
  // 0.1234 less and more 0.1044 psi.
  check_once(median, "lies in [0.02, 0.23] psi.</p>");
  const std::string worst = budget_of(page, "worst");
  CHECK(worst.rfind("Budget of the worst taxel (row 1, column 2)", 0) == 0);
  check_once(worst, "lies in [−0.34, −0.13] psi.</p>");
  check_once(worst, numbers({"−0.23", "0.052 psi"}));
}

TEST_CASE("a budget by hand: in kPa its widths are converted, beyond linearity it says so, of nothing no share") {
  ReportInput input = assessed_by_hand();
  input.unit = PressureUnit::kKilopascal;
  Budget& median = input.uncertainty->levels[3].median;
  median.linear = false;
  const std::string page = budget_of(uncertainty_section(input).value, "median");
  // 6.894757 times 0.0097014, 0.04, 0.051964, 0.1234.
  check_once(page, numbers({"1", "0.0669 kPa/mV", "0.28", "250", "64.0"}));
  check_once(page, numbers({"0.85", "0.358 kPa"}));
  check_once(page, "▲ The inverse is not linear");
  median.combined_psi = 0.0;
  CHECK(count(budget_of(uncertainty_section(input).value, "median"), "<td class=\"n\">0.0</td></tr>") == 2);
  input.uncertainty->levels.clear();
  check_once(uncertainty_section(input).value, "<p>Not assessed: the uncertainty rests on");
  input.uncertainty.reset();
  check_once(uncertainty_section(input).value, "<p>Not assessed: the uncertainty rests on");
}

TEST_CASE("levels with U by hand: readings, errors, taxels that are not linear, and where there is no reading") {
  const std::string page = uncertainty_section(assessed_by_hand()).value;
  const std::string table = page.substr(page.find("Error and U at every level"));
  check_once(table, level_head("0.0", "0.0") + numbers({"6", "0.12 ± 0.10", "−0.23 ± 0.20", "0"}) +
                        numbers({"6", "0.12 ± 0.30", "−0.23 ± 0.60", "0"}) + "</tr>");
  check_once(table, level_head("30.0", "206.8") + numbers({"6", "0.12 ± 0.20", "−0.23 ± 0.40", "▲ 1"}) +
                        numbers({"1", "0.12 ± 0.10", "−0.23 ± 0.10", "0"}) + "</tr>");
  check_once(table, level_head("60.0", "413.7") + numbers({"6", "0.12 ± 0.70", "−0.2 ± 1.4", "0"}) +
                        "<td colspan=\"4\">no reading</td></tr>");
  CHECK(count(table, "class=\"n\">not linear</th>") == 2);
  check_once(table, "figures of taxels in psi</caption>");
}

TEST_CASE("measuring intervals by hand: within 0.5, 1 and 2 per cent of the full pressure") {
  ReportInput input = assessed_by_hand();
  for (LevelUncertainty& level : input.uncertainty->levels) level.expanded_psi = {level.median.expanded_psi};
  input.uncertainty->levels[3].expanded_psi = {0.25};
  const std::string page = uncertainty_section(input).value;
  // 0.3, 0.6 and 1.2 psi of 60 psi; U is 0.1, 0.2, 0.7 psi going up, 0.25 and 0.3 psi going down.
  const auto interval = [](const char* share, double most, const std::string& up) {
    return std::string("<th scope=\"row\">") + share + " %: " + psi(most, 2) + "</th><td>increasing: " + up +
           "; decreasing: ";
  };
  check_once(page, interval("0.5", 0.3, psi(0.0, 1) + " to " + psi(30.0, 1)));
  check_once(page, interval("1.0", 0.6, psi(0.0, 1) + " to " + psi(30.0, 1)));
  check_once(page, interval("2.0", 1.2, psi(0.0, 1) + " to " + psi(60.0, 1)));
}

TEST_CASE("U over pressure by hand: median and worst taxel, each way") {
  const std::string page = uncertainty_section(assessed_by_hand()).value;
  const double chosen = 0.1044;
  LineChart chart;
  chart.title = "Expanded uncertainty of a corrected indication over pressure, increasing and decreasing";
  chart.x_label = "gauge pressure";
  chart.y_label = "U";
  chart.y_from_zero = true;
  chart.series = {{"median taxel, increasing", {0.0, 30.0, 60.0}, {0.1, 0.2, 0.7}, 0},
                  {"worst taxel, increasing", {0.0, 30.0, 60.0}, {0.2, 0.4, 1.4}, 2},
                  {"median taxel, decreasing", {30.0, 0.0}, {chosen, 0.3}, 1},
                  {"worst taxel, decreasing", {30.0, 0.0}, {chosen, 0.6}, 3}};
  check_both(page, chart);
}

TEST_CASE("the basis of each contribution by hand: what is missing, where a figure comes from, in both units") {
  const std::string page = uncertainty_section(assessed_by_hand()).value;
  const std::string basis = page.substr(page.find("How each contribution is evaluated"));
  CHECK(count(basis.substr(0, basis.find("</table>")), "<tr>") == 20);
  check_once(basis, ". Not assessed: no runs above 40 psi (275.8 kPa)</td>");
  check_once(basis, "; runs 3 to 6 at 40 psi (275.8 kPa)</td>");
  CHECK(count(basis, "Not assessed: ") == 1);
  check_once(basis, "<th scope=\"row\">reproducibility: mounting, a taxel’s own part</th>");
  check_once(page, "(below " + psi(0.01, 2) + " a metre at " + psi(60.0, 0) + ").");
  check_none(page, "overdue when the run began");
  ReportInput input = assessed_by_hand();
  input.uncertainty->reference.overdue = true;
  input.uncertainty->reference.calibration.certificate = "C-1";
  input.uncertainty->reference.calibration.due = "2024-05-01";
  check_once(uncertainty_section(input).value,
             "certificate C-1, due 2024-05-01, overdue when the run began; it covers");
}

TEST_CASE("conditions of use by hand: the median, what 95 of 100 lie below, the reason where U does not cover it") {
  ReportInput input = assessed_by_hand();
  CHECK(conditions_part(input).value.empty());
  CHECK(conditions_in_brief(input).value.empty());
  ConditionUncertainty covered, not_covered;
  covered.condition = UseCondition::kAnyHistory;
  covered.median_psi = 0.1044;
  // From 0 to 20 in steps of one: 19 of 20 lie below 19.
  for (int i = 20; i >= 0; --i) covered.expanded_psi.push_back(i);
  covered.expanded_psi.push_back(kNone);
  covered.basis = "runs up to 40 psi";
  not_covered.condition = UseCondition::kLater;
  not_covered.not_valid = "no later run above 40 psi";
  input.uncertainty->conditions = {covered, not_covered};
  const std::string table = conditions_part(input).value;
  check_once(table, std::string("<tr><th scope=\"row\">") + name_of(UseCondition::kAnyHistory) + "</th>" +
                        numbers({"0.10\u00A0psi (0.72\u00A0kPa)", "19\u00A0psi (130\u00A0kPa)"}) +
                        "<td>runs up to 40 psi (275.8 kPa)</td></tr>");
  check_once(table, "<td colspan=\"3\">not valid for this: no later run above 40 psi (275.8 kPa)</td></tr>");
  const auto brief = [&] { return conditions_in_brief(input).value; };
  const std::string covers = name_of(UseCondition::kAnyHistory), not_covers = name_of(UseCondition::kLater);
  check_once(brief(), "is valid for: " + covers + ". Not valid for: " + not_covers + ".</p>");
  input.uncertainty->conditions = {covered, covered};
  check_once(brief(), "is valid for: " + covers + "; " + covers + ". Not valid for: uses that are not named here.</p>");
  input.uncertainty->conditions = {not_covered};
  check_once(brief(), "is valid for: nothing. Not valid for: " + not_covers + ".</p>");
  input.uncertainty.reset();
  CHECK(conditions_part(input).value.empty());
  CHECK(brief().empty());
}
