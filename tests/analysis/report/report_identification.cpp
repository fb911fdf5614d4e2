// What the report says of itself, of instruments and of the run's way: certificate, due dates, signature, deviations.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/report.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// One level, as assess_uncertainty gives it.
Uncertainty some_uncertainty(const ReportInput& input) {
  Uncertainty uncertainty;
  LevelUncertainty level;
  level.pressure_psi = level.median.pressure_psi = level.worst.pressure_psi = 30.0;
  level.expanded_psi.assign(input.fit.array().size(), 0.3);
  level.median.taxel = level.worst.taxel = 1;
  level.median.combined_psi = level.worst.combined_psi = 0.15;
  level.median.expanded_psi = level.worst.expanded_psi = 0.3;
  uncertainty.levels = {level};
  uncertainty.reference = reference_uncertainty(input.run, input.laboratory.instruments);
  return uncertainty;
}

// Of "Instruments" alone, and of "Uncertainty".
std::string part_of(const std::string& page, const std::string& from, const std::string& to) {
  const std::size_t start = page.find(from), end = page.find(to, start);
  REQUIRE(start != std::string::npos);
  REQUIRE(end != std::string::npos);
  return page.substr(start, end - start);
}

const db::DeviceRecord kForceSensor{
    "force sensor", "ATI Nano17",
    "FT-1",         "",
    "simulated",    R"({"records_per_reading":50,"certificate":"","calibrated":"","due":""})"};

}  // namespace

TEST_CASE("a document without stated uncertainties is a test report everywhere, one with them a calibration report") {
  ReportInput input = example::example_input();
  input.laboratory.accreditation = "D-K-00000-01";
  const Report test = render_report(input);
  for (const char* place : {"<h1>Test report</h1>", "<title>Test report 12-", "\"document\":\"Test report\"",
                            "End of test report 12-", "content: \"Test report 12-", "Item tested"})
    CHECK(contains(test.html, place));
  CHECK_FALSE(contains(test.html, "alibration report"));
  CHECK_FALSE(contains(test.html, "Item calibrated"));
  CHECK(nlohmann::json::parse(test.json)["document"] == "Test report");
  input.uncertainty = some_uncertainty(input);
  const Report calibration = render_report(input);
  CHECK(contains(calibration.html, "<h1>Calibration report</h1>"));
  CHECK(contains(calibration.html, "Item calibrated"));
  CHECK_FALSE(contains(calibration.html, "est report"));
  CHECK(nlohmann::json::parse(calibration.json)["document"] == "Calibration report");
  require_well_formed(calibration.html);
}

TEST_CASE("a certificate needs an accreditation number, real data, uncertainties and a traceable pressure") {
  ReportInput input = example::example_input();
  input.laboratory.accreditation = "D-K-00000-01";
  input.laboratory.instruments[0].due = "2025-05-01";
  input.uncertainty = some_uncertainty(input);
  CHECK_FALSE(contains(render_report(input).html, "ertificate</h1>"));  // simulated
  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  const std::string page = render_report(input).html;
  CHECK(contains(page, "<h1>Calibration certificate</h1>"));
  CHECK(contains(page, "Issued under accreditation D-K-00000-01."));
  CHECK_FALSE(contains(page, "not issued by an accredited"));
  std::string heading = "<h1>Calibration report</h1>";
  SECTION("no number") { input.laboratory.accreditation.clear(); }
  SECTION("no reference") { input.run.devices.erase(input.run.devices.begin() + 1); }
  SECTION("overdue") { input.laboratory.instruments[0].due = "2024-05-01"; }
  SECTION("no certificate of the reference") {
    input.run.devices[1].calibration_json = "{}";
    input.laboratory.instruments.clear();
  }
  SECTION("no uncertainty") {
    input.uncertainty.reset();
    heading = "<h1>Test report</h1>";
  }
  CHECK(contains(render_report(input).html, heading));
  CHECK(contains(render_report(input).html, "Not issued by an accredited laboratory."));
}

TEST_CASE("an instrument that was overdue at the run is named as overdue, also on page 1") {
  ReportInput input = example::example_input();  // due 2024-05-01, run of 2024-05-06
  const std::string page = render_report(input).html;
  CHECK(contains(page, "OVERDUE since 2024-05-01 when the run was made"));
  const std::string first = part_of(page, "id=\"verdicts\"", "id=\"identification\"");
  CHECK(contains(first,
                 "pressure reference (PT-150, serial P-22): OVERDUE for calibration since 2024-05-01 when "
                 "measured: this run, held-out run, re-mounted"));
  input.laboratory.instruments[0].due = "2024-05-06";  // on its last day
  CHECK_FALSE(contains(render_report(input).html, "OVERDUE"));
  input.laboratory.instruments[0].due.clear();
  CHECK(contains(render_report(input).html, "due: not stated"));
}

TEST_CASE("the overall verdict names the overdue reference when that is its reason") {
  ReportInput input = example::example_input();
  for (db::VerdictRecord& verdict : input.verdicts) verdict.verdict = "pass";
  const auto first = [&] { return part_of(render_report(input).html, "All requirements together", "</p>"); };
  withhold_overdue(input.verdicts, 12, reference_uncertainty(input.run, input.laboratory.instruments));
  CHECK(contains(first(), "inconclusive</span>: reference overdue since 2024-05-01 when this run was made"));
  input.verdicts.back().verdict = "fail";  // fails whatever the reference
  CHECK_FALSE(contains(first(), "overdue"));
}

TEST_CASE("one reference has one certificate and one due date in every section, and contradictions are named") {
  ReportInput input = example::example_input();  // the run says C-2024-17, the laboratory file D-K 17, C-2024-18
  input.uncertainty = some_uncertainty(input);
  const std::string page = render_report(input).html;
  const nlohmann::json data = nlohmann::json::parse(data_text(page));
  const std::string instruments = part_of(page, "<caption>Instruments", "</table>");
  const std::string uncertainty = part_of(page, "id=\"uncertainty\"", "id=\"meaning\"");
  CHECK(contains(instruments, "certificate: C-2024-17"));
  CHECK_FALSE(contains(instruments, "certificate: D-K 17"));
  CHECK(contains(uncertainty, "certificate C-2024-17, due 2024-05-01, overdue when the run began"));
  CHECK(contains(part_of(page, "traceability of the pressure", "</tr>"), "certificate C-2024-17"));
  CHECK(data["sections"]["uncertainty"]["reading"]["reference"]["certificate"] == "C-2024-17");
  CHECK(data["sections"]["uncertainty"]["reading"]["reference"]["due"] == "2024-05-01");
  const nlohmann::json& device = data["identification"]["run"]["devices"][1];
  CHECK(device["certificate"] == "C-2024-17");
  CHECK(device["due"] == "2024-05-01");
  CHECK(device["overdue"] == true);
  const char* named = "contradiction: certificate C-2024-17 by the run, D-K 17, C-2024-18 by the laboratory file";
  CHECK(contains(instruments, named));
  CHECK(contains(part_of(page, "id=\"verdicts\"", "id=\"identification\""), named));
}

TEST_CASE("what was never filled in, and a text that is no date, are not printed as certificate and date") {
  ReportInput input = example::example_input();
  input.laboratory.instruments.clear();
  for (db::RunRecord* run : {&input.run, &input.held_out[0].run, &input.held_out[1].run, &input.held_out[2].run}) {
    run->devices[0].serial = "FILL-IN";
    run->devices[1].calibration_json = R"({"span_psi":[0,150],"certificate":"FILL-IN","due":"soon"})";
  }
  const std::string page = render_report(input).html;
  CHECK_FALSE(contains(page, "FILL-IN"));
  CHECK(contains(page, "certificate: not stated<br/>due: not stated"));
  CHECK(contains(page, "due: not a date: soon"));
  CHECK(contains(page,
                 "Pressure not traceable: no certificate of the pressure reference (PT-150, serial P-22) is stated."));
}

TEST_CASE("a report of objects states the traceability of the force, not of the pressure") {
  ReportInput input = example::example_input();
  input.evaluation = {};
  input.held_out.clear();
  input.verdicts.clear();
  input.history.presses = true;
  const auto table = [&] { return part_of(render_report(input).html, "Laboratory and customer", "</table>"); };
  const auto force = [&] {
    return nlohmann::json::parse(data_text(render_report(input).html))["identification"]["traceability"][0];
  };
  CHECK(contains(table(), "Force not traceable: the run does not state by which instrument it was measured."));
  CHECK_FALSE(contains(table(), "traceability of the pressure"));
  input.run.devices.push_back(kForceSensor);
  CHECK(contains(table(),
                 "Force not traceable: no certificate of the force sensor (ATI Nano17, serial FT-1) is stated."));
  CHECK(force()["quantity"] == "force");
  CHECK(force()["traceable"] == false);
  input.laboratory.instruments = {{"FT-1", "F-7", "ATI", "2024-01-31", "2025-01-31", ""}};
  CHECK(contains(table(),
                 "Force measured by ATI Nano17, serial FT-1: certificate F-7 of ATI, calibrated 2024-01-31, due "
                 "2025-01-31."));
  CHECK(force()["traceable"] == true);
  CHECK(contains(render_report(input).html, "<h1>Test report</h1>"));
}

TEST_CASE("the scanner's serial number is the same in every section") {
  ReportInput input = example::example_input();
  input.run.scanner_serial.clear();
  input.sensor->scanner_serial = "ANOTHER";
  const std::string page = render_report(input).html;
  CHECK(contains(page, "scanner electronics, serial number</th><td>SC-0042</td>"));
  CHECK(nlohmann::json::parse(data_text(page))["identification"]["run"]["scanner"] == "SC-0042");
}

TEST_CASE("a reference that fell due between measurement and issue is mentioned without effect") {
  ReportInput input = example::example_input();
  input.laboratory.instruments[0].due = "2024-05-31";
  const Report before = render_report(input);
  input.issued = "2024-06-01";
  const Report after = render_report(input);
  CHECK_FALSE(contains(before.html, "fell due"));
  CHECK(contains(after.html, "The pressure reference fell due on 2024-05-31, after the measurement"));
  CHECK(after.number == before.number);
}

TEST_CASE("a signature does not change the number, and a changed report names the one that it replaces") {
  ReportInput input = example::example_input();
  const Report draft = render_report(input);
  CHECK(contains(draft.html, "nobody has signed"));
  CHECK(draft.number == fmt::format("12-{}", draft.content_sha256.substr(0, 8)));
  input.approvals = {{12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T10:00:00Z", "", ""}};
  const Report signed_one = render_report(input);
  CHECK(signed_one.number == draft.number);
  CHECK(contains(signed_one.html, "C. Chief, 2024-06-01 10:00:00Z"));
  CHECK(contains(signed_one.html, "<th scope=\"row\">date of issue</th><td>2024-06-01</td>"));
  CHECK(contains(signed_one.html, "no earlier report of this run"));
  input.laboratory.customer = "Somebody else";
  const Report changed = render_report(input);
  CHECK(changed.number != draft.number);
  CHECK(contains(changed.html, "nobody has signed"));
  CHECK(contains(changed.html, "<th scope=\"row\">replaces</th><td>" + draft.number + "</td>"));
}

TEST_CASE("a report that replaces another states why on page 1 and in its data, and says when no reason is stated") {
  const auto row = [](const std::string& text) {
    return "<th scope=\"row\">reason for the change</th><td>" + text + "</td>";
  };
  ReportInput input = example::example_input();
  CHECK_FALSE(contains(render_report(input).html, "reason for the change"));
  input.approvals = {{12, "12-00000000", "0", "C. Chief", "2024-06-01T10:00:00Z", "", ""}};
  const Report bare = render_report(input);
  CHECK(contains(bare.html, row("not stated; it is needed to sign this report")));
  input.reason = "customer \"K & L\" corrected";
  const Report draft = render_report(input);
  CHECK(draft.number == bare.number);
  CHECK(contains(draft.html, row("customer &quot;K &amp; L&quot; corrected")));
  CHECK(draft.html.find("reason for the change") < draft.html.find("<nav"));
  const auto data = nlohmann::json::parse(draft.json);
  CHECK((data["replaces"] == "12-00000000" && data["reason"] == "customer \"K & L\" corrected"));
  // Signed, it keeps the reason that it was signed with.
  input.approvals.push_back({12, bare.number, "1", "C. Chief", "2024-06-02T10:00:00Z", "12-00000000", "as signed"});
  input.reason = "another";
  const Report signed_one = render_report(input);
  CHECK(contains(signed_one.html, row("as signed")));
  CHECK(nlohmann::json::parse(signed_one.json)["reason"] == "as signed");
  CHECK(nlohmann::json::parse(signed_one.json)["identification"]["approvals"][1]["reason"] == "as signed");
  input.approvals.back().reason.clear();  // signed before reasons were kept
  CHECK(contains(render_report(input).html, row("not stated")));
}

TEST_CASE("the method is in the page's unit with the other behind it, in the data in psi, with the pressure's medium") {
  ReportInput input = example::example_input();
  REQUIRE(!input.run.sequences.empty());
  input.method = {"3 repeats of 2 sweeps; a level every 4 psi, from 0 to 60 to 0 psi"};
  const auto page_in = [&](PressureUnit unit) {
    input.unit = unit;
    return render_report(input);
  };
  const Report kpa = page_in(PressureUnit::kKilopascal), psi = page_in(PressureUnit::kPsi);
  CHECK(contains(kpa.html, "a level every 27.58 kPa (4 psi), from 0 to 413.7 to 0 kPa (0 to 60 to 0 psi)</span>"));
  CHECK(contains(psi.html, "a level every 4 psi (27.58 kPa), from 0 to 60 to 0 psi (0 to 413.7 to 0 kPa)</span>"));
  CHECK(kpa.number == psi.number);
  CHECK(nlohmann::json::parse(psi.json)["identification"]["method"][0] == input.method[0]);
  CHECK(contains(kpa.html, "<th scope=\"row\">pressure medium</th><td>not stated</td>"));
  input.laboratory.medium = "dry air";
  CHECK(contains(render_report(input).html, "<th scope=\"row\">pressure medium</th><td>dry air</td>"));
}

TEST_CASE("the cable is the one that was typed, else the one stored with the scanner") {
  ReportInput input = example::example_input();
  input.run.devices[2].calibration_json = R"({"volts_per_count":7.6e-05,"cable":"W-17"})";
  CHECK(contains(render_report(input).html, "<th scope=\"row\">cable</th><td>W-17</td>"));
  input.laboratory.cable = "W-18";
  CHECK(contains(render_report(input).html, "<th scope=\"row\">cable</th><td>W-18</td>"));
}

TEST_CASE("retries, voids, flags and environment are listed as deviations, also when there were none") {
  ReportInput input = example::example_input();
  const std::string page = render_report(input).html;
  CHECK(contains(page, "branches void and done again</th><td>1 (12 frames)"));
  CHECK(contains(page, "3 of 3310: 2 dwell, 1 retried"));
  CHECK(contains(page, "went back by 2.1 kPa (0.31 psi)"));
  CHECK(contains(page, "temperature measured: 22.9 to 23.2 °C, 4 readings"));
  CHECK(contains(page, "row 3 answers weakly"));
  CHECK(contains(page, "rows 3 and 4 stand in each other’s place"));
  input.history = {};
  input.history.loaded = true;
  CHECK(contains(render_report(input).html, "branches void and done again</th><td>0 (0 frames)"));
}
