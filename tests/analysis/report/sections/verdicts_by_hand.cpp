// The statement of conformity by hand: values, limits and U as printed, marks, findings on the sensor, rules.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

constexpr PressureUnit kJudgedIn = PressureUnit::kPsi;

db::VerdictRecord judged_row(const char* criterion, double value, double limit, const char* unit,
                             const char* verdict = "pass", const char* rule = "simple") {
  return {12, 1, criterion, "array", value, limit, unit, rule, verdict, "", std::string(64, 'e'), 0};
}

JudgedUncertainty judged_u(const char* criterion, double expanded, const char* basis = "", const char* missing = "") {
  JudgedUncertainty u;
  u.criterion = criterion;
  u.scope = "array";
  u.expanded = expanded;
  u.basis = basis;
  u.missing = missing;
  u.run = 12;
  return u;
}

std::string value_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u("any", expanded);
  return judged_value(&known, judged_row("any", value, 0.0, unit), kJudgedIn).value;
}

std::string whole_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u("any", expanded);
  return judged_with_uncertainty(&known, judged_row("any", value, 0.0, unit), kJudgedIn).value;
}

ReportInput judged_input() {
  ReportInput input;
  input.run.run = 12;
  input.run.origin = "hardware";
  input.unit = kJudgedIn;
  return input;
}

std::string conformity_row(const char* criterion, const std::vector<std::string>& cells, const char* rule,
                           const std::string& mark) {
  return std::string("<tr><th scope=\"row\">") + criterion + "</th><td>array</td>" + numbers(cells) + "<td>" + rule +
         "</td><td>" + mark + "</td></tr>";
}

const std::string kPassed = "<span class=\"pass\"><span class=\"sign\">✓</span> pass</span>";

}  // namespace

TEST_CASE(
    "a judged value by hand: the place of its U where that is known, else three decimals of psi, two of per cent") {
  // 0.0996 is 0.10 psi and 0.687 is 0.69 kPa: hundredths of both. 1.23456 psi are 8.51199 kPa.
  CHECK(value_of(1.23456, "psi", 0.0996) == "1.23\u00A0psi (8.51\u00A0kPa)");
  for (const double unknown : {0.0, -1.0, kNone, std::numeric_limits<double>::infinity()})
    CHECK(value_of(1.23456, "psi", unknown) == "1.235\u00A0psi (8.51\u00A0kPa)");
  CHECK(judged_value(nullptr, judged_row("any", 1.23456, 0.0, "psi"), kJudgedIn).value == psi(1.23456, 3));
  for (const char* share : {"FS", "fs", "share of FS"}) {
    CHECK(value_of(0.0123462, share, 0.0123) == "1.2\u00A0%\u00A0FS");
    CHECK(value_of(0.0123462, share, 0.000123) == "1.235\u00A0%\u00A0FS");
    CHECK(value_of(0.0123462, share, 0.0) == "1.23\u00A0%\u00A0FS");
    CHECK(value_of(kNone, share, 0.0123) == "not available");
  }
  CHECK(value_of(1.0, "taxels", 0.0) == "1 taxel");
  CHECK(value_of(2.0, "taxels", 0.0) == "2 taxels");
  CHECK(value_of(1.0, "V", 0.0) == "1 V");
  CHECK(value_of(12.345678, "V", 0.5) == "12.346 V");
  CHECK(value_of(std::numeric_limits<double>::infinity(), "V", 0.0) == "not available");
  CHECK(judged_limit(judged_row("any", 0.0, 0.01554, "FS"), kJudgedIn).value == "1.55\u00A0%\u00A0FS");
}

TEST_CASE("a judged value with U by hand: in its unit, per cent of full scale, plain numbers, without U the value") {
  CHECK(whole_of(1.23456, "psi", 0.0996) == "1.23 ± 0.10\u00A0psi (8.51 ± 0.69\u00A0kPa)");
  CHECK(whole_of(0.0123462, "FS", 0.00123) == "1.23\u00A0%\u00A0FS ± 0.12");
  CHECK(whole_of(3.0, "taxels", 0.5) == "3 taxels ± 0.50");
  for (const double unknown : {0.0, -0.5, kNone}) CHECK(whole_of(3.0, "taxels", unknown) == "3 taxels");
  CHECK(whole_of(kNone, "taxels", 0.5) == "not available");
  CHECK(judged_with_uncertainty(nullptr, judged_row("any", 3.0, 0.0, "taxels"), kJudgedIn).value == "3 taxels");
}

TEST_CASE("requirements of one run by hand: value, U, limit, rule and mark of each") {
  ReportInput input = judged_input();
  input.verdicts = {judged_row("mean_compensation_error", 0.5213, 1.0, "psi"),
                    judged_row("distance_of_mean", 0.012345, 0.015, "FS", "fail", "guarded"),
                    judged_row("unfit_taxels", 1.0, 2.0, "taxels", "pass", "guarded"),
                    judged_row("mismatch", 0.02, 0.06, "FS", "report only", "report-only"),
                    judged_row("worst_taxel_error", 1.5, 2.0, "psi", "inconclusive"),
                    judged_row("slope", 2.5, 3.0, "V")};
  input.judged = {judged_u("mean_compensation_error", 0.0344, "5 repeats to 40 psi"),
                  judged_u("distance_of_mean", 0.00123, "12 sweeps"), judged_u("unfit_taxels", 0.0, "a count"),
                  judged_u("mismatch", kNone, "never read", "no certificate"), judged_u("slope", 0.5, "a line")};
  const std::string page = verdict_section(input).value;
  // U of 0.034 psi asks for thousandths, 0.237 kPa for hundredths; 0.5213 psi are 3.594 kPa.
  check_once(page, conformity_row("mean absolute error",
                                  {"0.521\u00A0psi (3.59\u00A0kPa)", "0.034\u00A0psi (0.24\u00A0kPa)", psi(1.0, 3)},
                                  "simple", kPassed));
  check_once(page, conformity_row("hysteresis of the mean",
                                  {"1.23\u00A0%\u00A0FS", "0.12\u00A0%\u00A0FS", "1.50\u00A0%\u00A0FS"}, "guarded",
                                  "<span class=\"fail\"><span class=\"sign\">✗</span> fail</span>"));
  check_once(page, conformity_row("taxels not modelled", {"1 taxel", "0", "2 taxels"}, "guarded", kPassed));
  check_once(page, conformity_row("non-uniformity", {"2.00\u00A0%\u00A0FS", "not known", "6.00\u00A0%\u00A0FS"},
                                  "report-only", "– no verdict"));
  check_once(page, conformity_row("worst taxel&#39;s mean error", {psi(1.5, 3), "not known", psi(2.0, 3)}, "simple",
                                  "<span class=\"doubt\"><span class=\"sign\">▲</span> inconclusive</span>"));
  check_once(page, conformity_row("slope", {"2.5 V", "0.50\u00A0V", "3 V"}, "simple", kPassed));
  // Each rule once, in the order of the rows; how U is formed once a criterion.
  CHECK(count(page, "<p>Decision rule ") == 3);
  CHECK(page.find("<p>Decision rule “simple”") < page.find("<p>Decision rule “guarded”"));
  const std::string basis = page.substr(page.find("How U of each judged figure is evaluated"));
  check_once(basis, "<tr><th scope=\"row\">mean absolute error</th><td>5 repeats to 40 psi (275.8 kPa)</td></tr>");
  check_once(basis, "<tr><th scope=\"row\">non-uniformity</th><td>not known: no certificate</td></tr>");
  CHECK(count(basis, "<tr>") == 5);
  check_once(page, "<p class=\"note\">Judged on: own run (calibration data). The limits file has the SHA-256 <code>" +
                       std::string(64, 'e') + "</code>.</p>");
  CHECK(count(page, "<caption>Requirements</caption>") == 1);
  input.verdicts.push_back(input.verdicts.front());
  const std::string twice = verdict_section(input).value;
  CHECK(count(twice.substr(twice.find("How U of each judged figure is evaluated")), "<tr>") == 5);
  input.judged.clear();
  check_none(verdict_section(input).value, "How U of each judged figure is evaluated");
  input.judgement.not_judged = "no independent data";
  const std::string not_judged = verdict_section(input).value;
  CHECK(count(not_judged, "<td>– not judged</td>") == 6);
  CHECK(count(not_judged, "<td>– no verdict</td>") == 1);
  check_once(not_judged, "<p class=\"note\">Figures of: ");
  input.verdicts.clear();
  const std::string no_rows = verdict_section(input).value;
  check_once(no_rows, "not judged: no independent data.");
  check_none(no_rows, "SHA-256");
  check_none(no_rows, "No tolerance limits were given");
}

TEST_CASE("several judged runs stand side by side, and each is named below the table") {
  ReportInput input = judged_input();
  input.verdicts = {judged_row("distance_of_mean", 0.01, 0.015, "FS"),
                    judged_row("distance_of_mean", 0.01, 0.015, "FS")};
  input.verdicts[1].run = 13;
  input.held_out = {{"a later day", input.run, {}}};
  input.held_out[0].evaluation.run = 13;
  const std::string page = verdict_section(input).value;
  check_none(page, "<caption>Requirements</caption>");
  check_once(page, "<caption>Requirements: value ± U and conformity on each run</caption>");
  check_once(page, "Judged on: own run (calibration data); a later day. The limits");
}

TEST_CASE("page 1 by hand: taxels left out, noisy taxels and swapped lines, none where there are none") {
  ReportInput input = judged_input();
  input.health.rows = 3;
  input.health.columns = 4;
  check_none(verdict_section(input).value, "Found on the sensor");
  check_once(verdict_section(input).value, "No tolerance limits were given");
  input.health.findings = {{3, "dead", "", true}, {5, "noisy", "", false}};
  const auto found = [&] {
    const std::string page = verdict_section(input).value, behind = "Found on the sensor:</span> ";
    const std::size_t from = page.find(behind) + behind.size();
    return page.substr(from, page.find("; see ", from) - from);
  };
  CHECK(found() == "1 of 12 taxels left out of every figure; 1 noisy taxel");
  input.health.findings = {{5, "noisy", "", false}, {6, "noisy", "", false}};
  input.health.swaps = {{true, 1, 2, 0.0, 0.0}, {false, 0, 3, 0.0, 0.0}};
  CHECK(found() == "2 noisy taxels; rows 1 and 2 swapped; columns 0 and 3 swapped");
  input.health.findings.clear();
  input.verdicts = {judged_row("distance_of_mean", 0.01, 0.015, "FS")};
  CHECK(found() == "rows 1 and 2 swapped; columns 0 and 3 swapped");
}
