// Method and identification by hand: sequences, conditions, deviations, void branches, events, settings, cable, order.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ReportInput carried_out() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.history.loaded = true;
  return input;
}

std::string method_row(const char* name, const std::string& value) {
  return std::string("<tr><th scope=\"row\">") + name + "</th><td>" + value + "</td></tr>";
}

std::size_t table_rows(const std::string& page, const char* caption) {
  const std::size_t from = page.find(std::string("<caption>") + caption);
  if (from == std::string::npos) return 0;
  return count(page.substr(from, page.find("</table>", from) - from), "<tr>") - 1;
}

}  // namespace

TEST_CASE("the method by hand: each sequence with its title, how it was carried out, repeats and frames") {
  ReportInput input = carried_out();
  check_once(method_part(input).value, "<tr><td colspan=\"4\">not stated</td></tr>");
  input.run.sequences = {{0, "up", "name = \"x\"\ntitle = \"All the way\"\n", "aa", 3, 31},
                         {1, "down", "title = \"at the very beginning\"\n", "bb", 5, 211},
                         {2, "open", "x\ntitle = \"never closed", "", 1, 2}};
  input.method = {"to 40 psi", ""};
  const auto page = [&] { return method_part(input).value; };
  check_once(page(),
             "<tr><th scope=\"row\">up<br/><span class=\"plain\">All the way</span><br/><span "
             "class=\"plain\">to 40 psi (275.8 kPa)</span></th>" +
                 numbers({"3", "31"}) + "<td><code>aa</code></td></tr>");
  check_once(page(), "<tr><th scope=\"row\">down</th>" + numbers({"5", "211"}) + "<td><code>bb</code></td></tr>");
  check_once(page(), "<tr><th scope=\"row\">open</th>" + numbers({"1", "2"}) + "<td>not available</td></tr>");
  check_none(page(), "<tr><td colspan=\"4\">not stated</td></tr>");
  input.run.sequences[2].recipe_toml = "\ntitle = \"\"";
  check_once(page(), "<tr><th scope=\"row\">open</th>");
}

TEST_CASE("conditions by hand: surroundings with one decimal and their units, what is not stated") {
  ReportInput input = carried_out();
  check_once(method_part(input).value, method_row("surroundings", "not stated"));
  input.history.surroundings = {
      {"temperature_c", 22.94, 23.24, 1}, {"supply_bar", 6.04, 6.26, 4}, {"humidity", 40, 41.5, 2}};
  input.laboratory.environment = "a cellar";
  input.laboratory.mounting = "glued";
  input.history.time_spent = "settling 40 %";
  check_once(method_part(input).value,
             method_row("surroundings",
                        "temperature measured: 22.9 to 23.2 °C, 1 reading<br/>air supply measured: 6.0 to "
                        "6.3 bar, 4 readings<br/>humidity: 40.0 to 41.5, 2 readings<br/>a cellar"));
  check_once(method_part(input).value, method_row("mounting and what lies on the sensor", "glued"));
  check_once(method_part(input).value, method_row("time by activity", "settling 40 %"));
}

TEST_CASE("deviations by hand: each kind of event counted, flags, checks, also where there were none") {
  ReportInput input = carried_out();
  RunHistory& history = input.history;
  std::string page = method_part(input).value;
  check_once(page, method_row("branches void and done again", "0 (0 frames)"));
  check_once(page, method_row("frames that carry a flag", "0 of 0"));
  check_once(page, method_row("checks of the set-up", "none recorded"));
  CHECK(table_rows(page, "Void branches") == 0);
  CHECK(table_rows(page, "Pauses, retries and warnings") == 0);
  history.frames = 31;
  history.flagged = 4;
  history.void_frames = 1;
  history.flags = {{"dwell", 3}, {"retried", 2}};
  history.voids = {{"up", 1, 2, 3, "went back by 4 psi"}};
  for (const auto& [kind, number] :
       {std::pair{"attempt", 1}, {"pause", 2}, {"suspension", 3}, {"prompt", 4}, {"warning", 5}})
    history.events.insert(history.events.end(), static_cast<std::size_t>(number), {12.6, kind, "at 40 psi"});
  history.checks = {{1, 0, "seating", "pass", "", {}}, {1, 1, "tare", "warning", "", {}}};
  input.laboratory.deviations = "cold";
  page = method_part(input).value;
  check_once(page, method_row("branches void and done again", "1 (1 frame)"));
  check_once(page, method_row("attempts at frames and branches after a fault", "1"));
  check_once(page, method_row("frames that carry a flag", "4 of 31: 3 dwell, 2 retried"));
  check_once(page, method_row("pauses, suspensions, questions to the operator", "2, 3, 4"));
  check_once(page, method_row("warnings", "5"));
  check_once(page, method_row("checks of the set-up", "seating: pass; tare: warning"));
  check_once(page, method_row("operator’s entry", "cold"));
  // Repeat, branch and attempt are counted from 1.
  check_once(page, "<tr><th scope=\"row\">up</th>" + numbers({"2", "3", "4"}) +
                       "<td>went back by 4 psi (27.58 kPa)</td></tr>");
  CHECK(count(page, "<tr><td class=\"n\">13</td><td>prompt</td><td>at 40 psi (275.8 kPa)</td></tr>") == 4);
  history.loaded = false;
  check_once(method_part(input).value, "Deviations from the method: not available.");
  check_none(method_part(input).value, "<caption>Deviations from the method</caption>");
}

TEST_CASE("forty void branches and events are printed, of more the number is told") {
  ReportInput input = carried_out();
  input.history.voids.assign(40, {"up", 0, 0, 0, "broke"});
  input.history.events.assign(40, {1.0, "pause", ""});
  const auto rows_and_note = [&] {
    const std::string page = method_part(input).value;
    return std::vector<std::size_t>{table_rows(page, "Void branches"), table_rows(page, "Pauses, retries and warnings"),
                                    count(page, "The first 40 of each are printed")};
  };
  CHECK(rows_and_note() == std::vector<std::size_t>{40, 40, 0});
  input.history.voids.push_back({"up", 0, 0, 0, "broke"});
  CHECK(rows_and_note() == std::vector<std::size_t>{40, 40, 1});
  input.history.voids.clear();
  input.history.events.push_back({1.0, "pause", ""});
  CHECK(rows_and_note() == std::vector<std::size_t>{0, 40, 1});
}

TEST_CASE("identification by hand: the array's shape, cable, further runs and settings") {
  ReportInput input = carried_out();
  const auto page = [&] { return identification_section(input).value; };
  check_once(page(), method_row("array", "0 rows × 0 columns"));
  input.health.rows = 1;
  input.health.columns = 2;
  check_once(page(), method_row("array", "1 row × 2 columns"));
  input.fit.rows = 3;
  check_once(page(), method_row("array", "3 rows × 2 columns"));
  input.fit.columns = 1;
  check_once(page(), method_row("array", "3 rows × 1 column"));
  check_once(page(), method_row("scanner firmware", "not stated"));
  check_once(page(), method_row("further runs used", "none"));
  db::RunRecord further;
  further.run = 31;
  further.started_utc = "2024-05-06T07:08:09Z";
  further.sequences = {{0, "hold", "", "", 1, 1}, {1, "rate", "", "", 1, 1}};
  input.further = {further, further};
  input.further[1].run = 32;
  input.further[1].sequences.clear();
  check_once(page(), method_row("further runs used",
                                "run 31: hold, rate, 2024-05-06 07:08:09Z<br/>run 32: not stated, "
                                "2024-05-06 07:08:09Z"));
  const auto cable = [&](const char* calibration) {
    input.run.devices = {{"regulator", "R", "1", "9", "simulated", R"({"cable":"another"})"},
                         {"tactile scanner", "S", "2", "0.9", "simulated", calibration}};
    return page();
  };
  check_once(cable(R"({"cable":"W-17"})"), method_row("cable", "W-17"));
  check_once(page(), method_row("scanner firmware", "0.9"));
  for (const char* none : {R"({"cable":17})", R"({"line":"W-17"})", "[]", ""})
    check_once(cable(none), method_row("cable", "not stated"));
  input.laboratory.cable = "W-18";
  check_once(cable(R"({"cable":"W-17"})"), method_row("cable", "W-18"));
  const auto settings = [&](const char* json) {
    input.run.overrides_json = json;
    return page();
  };
  const char* const head = "settings changed on the command line";
  check_once(settings(R"([{"key":"a.b","value":"1"},{"key":"c","value":"x"}])"), method_row(head, "a.b = 1<br/>c = x"));
  check_once(settings("[]"), method_row(head, "none"));
  check_once(settings("as typed"), method_row(head, "as typed"));
  for (const char* other : {R"([{"key":"a","value":1}])", R"([{"key":1,"value":"a"}])", R"([{"value":"a"}])",
                            R"([{"key":"a"}])", R"([7])", R"({"key":"a","value":"b"})"})
    check_once(settings(other), method_row(head, html::Text(other).value));
}

TEST_CASE("identification by hand: order and metadata, the outcome's reason, void runs, a changed source") {
  ReportInput input = carried_out();
  const auto page = [&] { return identification_section(input).value; };
  input.laboratory.order = "L-1";
  check_once(page(), method_row("order", "L-1"));
  check_once(page(), method_row("declared void", "no"));
  input.run.tags = {"lot=7", "plain", "shelf=B"};
  check_once(page(), method_row("lot", "7") + "\n" + method_row("metadata shelf", "B"));
  input.run.tags = {"order=R-1"};
  CHECK(count(page(), method_row("order", "R-1 (laboratory file: L-1)")) == 1);
  CHECK(count(page(), method_row("order", "R-1")) == 1);
  input.laboratory.order = "R-1";
  CHECK(count(page(), method_row("order", "R-1")) == 2);
  input.laboratory.order.clear();
  CHECK(count(page(), method_row("order", "R-1")) == 2);
  input.frame_count = 3310;
  input.evaluation.frames = 3300;
  check_once(page(), method_row("frames stored", "3310") + "\n" + method_row("frames evaluated", "3300"));
  check_none(page(), "dirty");
  input.run.git_dirty = true;
  check_once(page(), ", source changed since that commit (dirty)");
  input.run.reason = "the air failed";
  check_once(page(), ": the air failed</td>");
}
