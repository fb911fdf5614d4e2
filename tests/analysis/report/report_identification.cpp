// What the report is, and whose instruments and signatures it names: document, due dates, replacement, deviations.
#include <fmt/format.h>

#include <catch2/catch.hpp>

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

}  // namespace

TEST_CASE("a calibration needs uncertainties, a certificate a number, real data and a traceable pressure besides") {
  ReportInput input = example::example_input();
  const auto document = [&] { return report_json(input)["document"]; };
  input.laboratory.accreditation = "D-K-00000-01";
  input.laboratory.instruments[0].due = "2025-05-01";
  CHECK(document() == "Test report");
  input.uncertainty = some_uncertainty(input);
  require_well_formed(render_report(input).html);
  CHECK(document() == "Calibration report");  // simulated
  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  CHECK(document() == "Calibration certificate");
  std::string other = "Calibration report";
  SECTION("no number") { input.laboratory.accreditation.clear(); }
  SECTION("no reference") { input.run.devices.erase(input.run.devices.begin() + 1); }
  SECTION("overdue") { input.laboratory.instruments[0].due = "2024-05-01"; }
  SECTION("no certificate of the reference") {
    input.run.devices[1].calibration_json = "{}";
    input.laboratory.instruments.clear();
  }
  SECTION("no uncertainty") {
    input.uncertainty.reset();
    other = "Test report";
  }
  CHECK(document() == other);
}

TEST_CASE("an instrument is overdue at a run from the day after its last one") {
  ReportInput input = example::example_input();  // due 2024-05-01, run of 2024-05-06
  const auto overdue = [&] { return report_json(input)["identification"]["run"]["devices"][1]["overdue"]; };
  CHECK(overdue() == true);
  CHECK(contains(render_report(input).html, "OVERDUE"));
  input.laboratory.instruments[0].due = "2024-05-06";  // on its last day
  CHECK(overdue() == false);
  CHECK_FALSE(contains(render_report(input).html, "OVERDUE"));
}

TEST_CASE("one reference has one certificate and one due date in every section") {
  ReportInput input = example::example_input();  // the run says C-2024-17, the laboratory file D-K 17, C-2024-18
  input.uncertainty = some_uncertainty(input);
  const nlohmann::json data = report_json(input);
  const nlohmann::json& reference = data["sections"]["uncertainty"]["reading"]["reference"];
  const nlohmann::json& device = data["identification"]["run"]["devices"][1];
  for (const nlohmann::json* place : {&reference, &device}) {
    CHECK((*place)["certificate"] == "C-2024-17");
    CHECK((*place)["due"] == "2024-05-01");
    CHECK((*place)["overdue"] == true);
  }
}

TEST_CASE("what was never filled in is not printed") {
  ReportInput input = example::example_input();
  input.laboratory.instruments.clear();
  for (db::RunRecord* run : {&input.run, &input.held_out[0].run, &input.held_out[1].run, &input.held_out[2].run}) {
    run->devices[0].serial = "FILL-IN";
    run->devices[1].calibration_json = R"({"span_psi":[0,150],"certificate":"FILL-IN","due":"soon"})";
  }
  CHECK_FALSE(contains(render_report(input).html, "FILL-IN"));
}

TEST_CASE("scanner and cable are those of the run's devices where nothing else was typed") {
  ReportInput input = example::example_input();
  input.run.scanner_serial.clear();
  input.sensor->scanner_serial = "ANOTHER";
  CHECK(report_json(input)["identification"]["run"]["scanner"] == "SC-0042");
  input.run.devices[2].calibration_json = R"({"volts_per_count":7.6e-05,"cable":"W-17"})";
  CHECK(contains(render_report(input).html, "<td>W-17</td>"));
  input.laboratory.cable = "W-18";
  CHECK(contains(render_report(input).html, "<td>W-18</td>"));
}

TEST_CASE(
    "a signature does not change the number, and a changed report names the one that it replaces, with a reason") {
  ReportInput input = example::example_input();
  const Report draft = render_report(input);
  CHECK(draft.number == fmt::format("12-{}", draft.content_sha256.substr(0, 8)));
  input.approvals = {{12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T10:00:00Z", "", ""}};
  const Report signed_one = render_report(input);
  CHECK(signed_one.number == draft.number);
  CHECK(contains(signed_one.html, "<td>2024-06-01</td>"));
  input.laboratory.customer = "Somebody else";
  const Report changed = render_report(input);
  CHECK(changed.number != draft.number);
  CHECK(report_json(input)["replaces"] == draft.number);
  input.reason = "customer \"K & L\" corrected";
  input.issued = "2024-06-02";
  CHECK(render_report(input).number == changed.number);
  CHECK(report_json(input)["reason"] == "customer \"K & L\" corrected");
  // Signed, it keeps the reason that it was signed with.
  input.approvals.push_back({12, changed.number, "1", "C. Chief", "2024-06-02T10:00:00Z", draft.number, "as signed"});
  input.reason = "another";
  CHECK(report_json(input)["reason"] == "as signed");
  CHECK(report_json(input)["identification"]["approvals"][1]["reason"] == "as signed");
}

TEST_CASE("the page's unit changes neither the report's number nor the method in its data") {
  ReportInput input = example::example_input();
  input.method = {"3 repeats, 0 to 60 to 0 psi"};
  const std::string number = render_report(input).number;
  input.unit = PressureUnit::kPsi;
  CHECK(render_report(input).number == number);
  CHECK(report_json(input)["identification"]["method"][0] == input.method[0]);
}

TEST_CASE("retries, voids, flags and surroundings are shown, also when there were none") {
  ReportInput input = example::example_input();
  const std::string page = render_report(input).html;
  for (const char* part : {"1 (12 frames)", "3 of 3310", "2 dwell, 1 retried", "2.1 kPa (0.31 psi)", "22.9 to 23.2 °C"})
    CHECK(contains(page, part));
  input.history = {};
  input.history.loaded = true;
  CHECK(contains(render_report(input).html, "0 (0 frames)"));
}
