// The runs judged and their instruments by hand: titles, deciding runs, tables across runs, traceability, warnings.
#include "analysis/report/data/judged_runs.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/data/traceability.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

db::VerdictRecord verdict_on(std::int64_t run, const char* criterion, double value, const char* verdict) {
  db::VerdictRecord row;
  row.run = run;
  row.criterion = criterion;
  row.scope = "array";
  row.value = value;
  row.limit = 0.015;
  row.unit = "FS";
  row.rule = "simple";
  row.verdict = verdict;
  row.limits_sha256 = "aa";
  return row;
}

// Run 12 of the report and held-out runs 13 to 13 + others - 1.
ReportInput judged_by_runs(int others) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = 12;
  input.run.origin = "hardware";
  input.run.started_utc = "2024-05-06T07:08:09Z";
  for (int i = 0; i < others; ++i) {
    HeldOut held_out{"run " + std::string(1, static_cast<char>('A' + i)), input.run, {}};
    held_out.run.run = held_out.evaluation.run = 13 + i;
    input.held_out.push_back(held_out);
  }
  return input;
}

std::string mark_of(const char* kind, const char* sign, const char* words) {
  return std::string("<span class=\"") + kind + "\"><span class=\"sign\">" + sign + "</span> " + words + "</span>";
}

const std::string kPassMark = mark_of("pass", "✓", "pass"), kFailMark = mark_of("fail", "✗", "fail");

db::DeviceRecord instrument(const char* role, const char* model, const char* serial, const char* calibration) {
  return {role, model, serial, "", "hardware", calibration};
}

}  // namespace

TEST_CASE("judged runs by hand: the title of each, and whether the own run is the models' own") {
  ReportInput input = judged_by_runs(1);
  CHECK(title_of_judged(input, 12) == "own run (calibration data)");
  CHECK(title_of_judged(input, 13) == "run A");
  CHECK(title_of_judged(input, 14) == "run 14, no part of this report");
  input.verdicts = {verdict_on(12, "mismatch", 0.01, "pass"), verdict_on(13, "mismatch", 0.01, "pass")};
  input.verdicts[1].model_run = 9;  // of another run's row
  CHECK(title_of_judged(input, 12) == "own run (calibration data)");
  input.verdicts[0].model_run = 12;
  CHECK(title_of_judged(input, 12) == "own run (calibration data)");
  input.verdicts[0].model_run = 9;
  CHECK(title_of_judged(input, 12) == "this run");
  input.verdicts.push_back(verdict_on(99, "mismatch", 0.01, "fail"));
  const std::vector<JudgedRun> runs = judged_runs(input);
  REQUIRE(runs.size() == 3);
  CHECK((runs[0].run == &input.run && runs[0].number == 12 && runs[0].verdict == Verdict::kPass));
  CHECK((runs[1].run == &input.held_out[0].run && runs[1].title == "run A"));
  CHECK((runs[2].run == nullptr && runs[2].verdict == Verdict::kFail));
  // A held-out run with the report's own number is the report's own.
  input.held_out[0].evaluation.run = 12;
  CHECK(judged_runs(input)[0].run == &input.run);
}

TEST_CASE("judged runs by hand: the overall verdict, who decided it, stored verdicts, remarks and doubt") {
  ReportInput input = judged_by_runs(3);
  input.verdicts = {verdict_on(13, "mismatch", 0.01, "pass"), verdict_on(14, "mismatch", 0.01, "pass")};
  const auto part = [&] { return overall_part(input).value; };
  CHECK(part() == "<p>All requirements together: " + kPassMark + ".</p>\n");
  input.verdicts.push_back(verdict_on(15, "mismatch", 0.02, "fail"));
  check_once(part(), kFailMark + ", decided by run C.</p>");
  input.verdicts[0].verdict = "fail";
  check_once(part(), kFailMark + ", decided by run A and run C.</p>");
  input.verdicts[1].verdict = "fail";
  check_once(part(), kFailMark + ".</p>");
  input.verdicts.resize(1);
  input.verdicts[0].verdict = "conditional pass";
  input.judgement.not_assessed = {{"creep", "no hold"}};
  check_once(part(), "conditional pass</span>, under repeatability conditions only.</p>");
  input.judgement.overdue = "reference overdue since 2024-01-31";
  check_once(part(), "conditional pass</span>, under repeatability conditions only.</p>");
  input.verdicts[0].verdict = "inconclusive";
  check_once(part(), "inconclusive</span>: reference overdue.</p>");
  input.judgement.overdue.clear();
  check_once(part(), "inconclusive</span>.</p>");
  input.verdicts[0].verdict = "report only";
  CHECK(part() == "<p>Conformity is not stated: the limits file asks for a report only.</p>\n");
  input.judgement.stored_worse = {verdict_on(13, "mismatch", 0.1, "fail"), verdict_on(13, "mpe", 0.1, "inconclusive"),
                                  verdict_on(15, "mismatch", 0.1, "conditional fail")};
  input.judgement.stored_worse[2].limits_sha256 = "bb";
  check_once(part(), "<p>Stored verdict on these models, worse than the one above: " + kFailMark +
                         " (run A: fail; run C: conditional fail), by the limits with the SHA-256 <code>aa, "
                         "bb</code>.</p>");
  input.judgement.remarks = {"run 14 is void"};
  input.more.previous.emplace();
  check_once(part(), "<p class=\"fail\"><span class=\"sign\">✗</span> run 14 is void</p>");
  CHECK(count(part(), "<p class=\"fail\">") == 1);
  input.more.previous->doubt = "May is in doubt.";
  check_once(part(), "<p class=\"fail\"><span class=\"sign\">✗</span> May is in doubt.</p>");
  input.judgement.not_judged = "no independent data";
  check_once(part(), "<p>All requirements together: " + mark_of("doubt", "▲", "inconclusive") +
                         ", not judged: no independent data.</p>");
  CHECK(judged_runs_part(input).value.empty());
}

TEST_CASE("judged runs by hand: the statement's condition in words") {
  JudgementNotes notes;
  CHECK(statement_in_words(Verdict::kPass, notes) == "pass");
  notes.not_assessed = {{"creep", ""}, {"temperature", ""}};
  CHECK(statement_in_words(Verdict::kPass, notes) == "pass, under repeatability conditions only");
  CHECK(statement_in_words(Verdict::kConditionalFail, notes) == "conditional fail");
  CHECK(statement_in_words(Verdict::kFail, notes) == "fail");
  CHECK(statement_in_words(Verdict::kInconclusive, notes) == "inconclusive");
  CHECK(not_assessed_in_words(notes) == "creep; temperature");
}

TEST_CASE(
    "judged runs by hand: a row of each run with its trajectory, what the errors hold for, what is not assessed") {
  ReportInput input = judged_by_runs(1);
  input.verdicts = {verdict_on(13, "mismatch", 0.01, "pass"), verdict_on(99, "mismatch", 0.02, "fail")};
  JudgedTrajectory fitted{13, Trajectory::kAsFitted, 4, 0.25, 2.0, 1.0, true},
      random{14, Trajectory::kRandomReversals, 32, 0.87, 2.0, 2.0, false};
  const auto part = [&] { return judged_runs_part(input).value; };
  check_once(part(), "<tr><th scope=\"row\">run A</th>" + numbers({"13"}) +
                         "<td>2024-05-06 07:08:09Z</td><td>–</td><td>" + kPassMark + "</td></tr>");
  check_once(part(), "<tr><th scope=\"row\">run 99, no part of this report</th>" + numbers({"–"}) +
                         "<td>–</td><td>–</td><td>" + kFailMark + "</td></tr>");
  check_none(part(), "The errors hold for");
  input.judgement.trajectories = {random, fitted, random};
  check_once(part(), "<td>" + in_words(fitted) + "</td>");
  check_once(part(), "judged (random reversals, set-points as fitted), and for no other.</p>");
  check_none(part(), "Not assessed: not covered");
  input.judgement.not_assessed = {{"creep", "no hold"}, {"mounting", "one mount"}};
  check_once(part(),
             "<tr><th scope=\"row\">creep</th><td>no hold</td></tr>\n<tr><th scope=\"row\">mounting</th><td>one "
             "mount</td></tr>");
  for (db::VerdictRecord& verdict : input.verdicts) verdict.verdict = "report only";
  CHECK(count(part(), "<td>– no verdict</td></tr>") == 2);
}

TEST_CASE("judged runs by hand: requirements across three runs a table, values with U, a dash where there is none") {
  ReportInput input = judged_by_runs(4);
  for (int i = 0; i < 4; ++i) input.verdicts.push_back(verdict_on(13 + i, "mismatch", 0.01 + 0.001 * i, "pass"));
  input.verdicts.push_back(verdict_on(14, "mpe", 0.02, "fail"));
  input.verdicts.push_back(verdict_on(14, "mismatch", 0.014, "pass"));
  input.verdicts.back().scope = "40 psi up";
  JudgedUncertainty known;
  known.criterion = "mismatch";
  known.scope = "array";
  known.run = 14;
  known.expanded = 0.001;
  input.judged = {known};
  const std::string page = criteria_by_run(input).value;
  CHECK(count(page, "<table") == 2);
  const std::string first = page.substr(0, page.find("</table>"));
  check_once(first, "<th scope=\"col\">run A</th><th scope=\"col\">run B</th><th scope=\"col\">run C</th></tr>");
  const std::string limit = "<td class=\"n\">1.50\u00A0%\u00A0FS</td>";
  check_once(first, "<th scope=\"row\">non-uniformity</th><td>array</td>" + limit + "<td>1.00\u00A0%\u00A0FS<br/>" +
                        kPassMark + "</td><td>1.10\u00A0%\u00A0FS ± 0.10<br/>" + kPassMark +
                        "</td><td>1.20\u00A0%\u00A0FS<br/>" + kPassMark + "</td></tr>");
  check_once(first, "<th scope=\"row\">maximum permissible error</th><td>array</td>" + limit +
                        "<td>–</td><td>2.00\u00A0%\u00A0FS<br/>" + kFailMark + "</td><td>–</td></tr>");
  check_once(first, "<td>40 psi (275.8 kPa) increasing</td>" + limit + "<td>–</td><td>1.40\u00A0%\u00A0FS<br/>" +
                        kPassMark + "</td><td>–</td></tr>");
  CHECK(count(first, "<tr>") == 4);
  const std::string second = page.substr(first.size());
  check_once(second, limit + "<td>1.30\u00A0%\u00A0FS<br/>" + kPassMark + "</td></tr>");
  CHECK(count(second, "<td>–</td></tr>") == 2);
  input.verdicts.erase(input.verdicts.begin() + 3);
  CHECK(count(criteria_by_run(input).value, "<table") == 1);
}

TEST_CASE("traceability by hand: the statement with all that is stated of the instrument, and with less") {
  ReportInput input = judged_by_runs(0);
  input.evaluation.levels.resize(1);
  const auto pressure = [&](const char* calibration) {
    input.run.devices = {instrument("regulator", "VPPM", "R-1", "{}"),
                         instrument("pressure reference", "PT", "P-1", calibration)};
    const std::vector<Traceability> all = traceability_of(input);
    REQUIRE(all.size() == 1);
    CHECK(all[0].title == "traceability of the pressure");
    return all[0].statement + (all[0].traceable ? " [traceable]" : "");
  };
  CHECK(pressure(R"({"certificate":"C-1","due":"2024-05-06"})") ==
        "Pressure measured by PT, serial P-1: certificate C-1, due 2024-05-06. [traceable]");
  CHECK(pressure(R"({"certificate":"C-1","due":"2024-05-05"})") ==
        "Pressure measured by PT, serial P-1: certificate C-1. Overdue since 2024-05-05 when measured: not covered by "
        "the "
        "certificate.");
  CHECK(pressure(R"({"certificate":"C-1"})") ==
        "Pressure measured by PT, serial P-1: certificate C-1, due date not stated. [traceable]");
  input.laboratory.instruments = {{"P-1", "", "a laboratory", "2023-01-31", "", ""}};
  CHECK(pressure(R"({"certificate":"C-1"})") ==
        "Pressure measured by PT, serial P-1: certificate C-1 of a laboratory, calibrated 2023-01-31, due date not "
        "stated. [traceable]");
  CHECK(pressure("{}") ==
        "Pressure not traceable: no certificate of the pressure reference (PT, serial P-1) is stated.");
  input.run.devices.pop_back();
  CHECK(traceability_of(input)[0].statement.rfind("Pressure not independently traceable", 0) == 0);
}

TEST_CASE("traceability by hand: a run that presses states force and place, and pressure where it was evaluated too") {
  ReportInput input = judged_by_runs(0);
  const auto quantities = [&] {
    std::string words;
    for (const auto& one : nlohmann::json::parse(traceability_json(input)))
      words += one["quantity"].get<std::string>() + " ";
    return words;
  };
  CHECK(quantities() == "pressure ");
  input.history.presses = true;
  CHECK(quantities() == "force place ");
  input.evaluation.levels.resize(1);
  CHECK(quantities() == "pressure force place ");
  input.run.devices = {instrument("stage x", "", "", R"({"certificate":"S-1"})")};
  const std::vector<Traceability> all = traceability_of(input);
  CHECK(all[1].statement == "Force not traceable: the run does not state by which instrument it was measured.");
  CHECK(all[2].statement ==
        "Place measured by model not stated, serial not stated: certificate S-1, due date not stated.");
  CHECK((!all[1].traceable && all[2].traceable));
  CHECK(nlohmann::json::parse(traceability_json(input))[2]["traceable"] == true);
}

TEST_CASE("instruments by hand: each that was overdue once with its runs, and the reason of an inconclusive verdict") {
  ReportInput input = judged_by_runs(2);
  CHECK(instruments_warning(input).value.empty());
  const db::DeviceRecord late =
      instrument("pressure reference", "PT", "P-1", R"({"certificate":"C-1","due":"2024-05-05"})");
  input.run.devices = {late, instrument("stage", "ST", "S-1", R"({"due":"2024-05-06"})")};
  input.held_out[1].run.devices = {late};
  check_once(
      instruments_warning(input).value,
      "pressure reference (PT, serial P-1): OVERDUE for calibration since 2024-05-05 when measured: this run, run "
      "B.</span></p>");
  CHECK(count(instruments_warning(input).value, "<p>") == 1);
  input.held_out[0].run.devices = {
      instrument("pressure reference", "PT", "P-1", R"({"certificate":"FILL-IN","due":"soon"})")};
  const std::string remarks = instruments_warning(input).value;
  CHECK(count(remarks, "<span class=\"doubt\">") >= 1);
  const std::size_t before = count(remarks, "<p>");
  input.held_out.push_back(input.held_out[0]);  // the same once more
  CHECK(count(instruments_warning(input).value, "<p>") == before);
  input.held_out.pop_back();

  CHECK(reason_of_verdict(input).empty());
  input.verdicts = {verdict_on(13, "mpe", 0.01, "inconclusive")};
  CHECK(reason_of_verdict(input).empty());  // run A was in date
  input.verdicts.push_back(verdict_on(14, "mpe", 0.01, "pass"));
  CHECK(reason_of_verdict(input) == "reference overdue since 2024-05-05 when run B was made");
  input.verdicts[1].run = 12;
  CHECK(reason_of_verdict(input) == "reference overdue since 2024-05-05 when this run was made");
  check_once(overall_part(input).value,
             ": reference overdue since 2024-05-05 when this run was made, decided by run A.</p>");
  input.verdicts[0].verdict = "fail";
  CHECK(reason_of_verdict(input).empty());
}
