// What the report is, and whose instruments and signatures it names: document, due dates, replacement, deviations.
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

const db::DeviceRecord kForceSensor{
    "force sensor", "ATI Nano17",
    "FT-1",         "",
    "simulated",    R"({"records_per_reading":50,"certificate":"","calibrated":"","due":""})"};

}  // namespace

TEST_CASE("a document without stated uncertainties is a test report, one with them a calibration report") {
  ReportInput input = example::example_input();
  input.laboratory.accreditation = "D-K-00000-01";
  const Report test = render_report(input);
  CHECK_FALSE(contains(test.html, "alibration report"));
  CHECK(nlohmann::json::parse(test.json)["document"] == "Test report");
  input.uncertainty = some_uncertainty(input);
  const Report calibration = render_report(input);
  CHECK_FALSE(contains(calibration.html, "est report"));
  CHECK(nlohmann::json::parse(calibration.json)["document"] == "Calibration report");
  require_well_formed(calibration.html);
}

TEST_CASE("a certificate needs an accreditation number, real data, uncertainties and a traceable pressure") {
  ReportInput input = example::example_input();
  input.laboratory.accreditation = "D-K-00000-01";
  input.laboratory.instruments[0].due = "2025-05-01";
  input.uncertainty = some_uncertainty(input);
  const auto document = [&] { return nlohmann::json::parse(render_report(input).json)["document"]; };
  CHECK(document() == "Calibration report");  // simulated
  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  CHECK(document() == "Calibration certificate");
  CHECK(contains(render_report(input).html, "D-K-00000-01"));
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
  const auto overdue = [&] {
    return nlohmann::json::parse(render_report(input).json)["identification"]["run"]["devices"][1]["overdue"];
  };
  CHECK(overdue() == true);
  CHECK(contains(render_report(input).html, "OVERDUE"));
  input.laboratory.instruments[0].due = "2024-05-06";  // on its last day
  CHECK(overdue() == false);
  CHECK_FALSE(contains(render_report(input).html, "OVERDUE"));
}

TEST_CASE("one reference has one certificate and one due date in every section") {
  ReportInput input = example::example_input();  // the run says C-2024-17, the laboratory file D-K 17, C-2024-18
  input.uncertainty = some_uncertainty(input);
  const nlohmann::json data = nlohmann::json::parse(render_report(input).json);
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

TEST_CASE("a report of objects states the traceability of the force, not of the pressure") {
  ReportInput input = example::example_input();
  input.evaluation = {};
  input.held_out.clear();
  input.verdicts.clear();
  input.history.presses = true;
  const auto force = [&] {
    return nlohmann::json::parse(render_report(input).json)["identification"]["traceability"][0];
  };
  CHECK(force()["quantity"] == "force");
  CHECK(force()["traceable"] == false);
  input.run.devices.push_back(kForceSensor);
  CHECK(force()["traceable"] == false);
  input.laboratory.instruments = {{"FT-1", "F-7", "ATI", "2024-01-31", "2025-01-31", ""}};
  CHECK(force()["traceable"] == true);
  CHECK(nlohmann::json::parse(render_report(input).json)["document"] == "Test report");
}

TEST_CASE("scanner and cable are those of the run's devices where nothing else was typed") {
  ReportInput input = example::example_input();
  input.run.scanner_serial.clear();
  input.sensor->scanner_serial = "ANOTHER";
  CHECK(nlohmann::json::parse(render_report(input).json)["identification"]["run"]["scanner"] == "SC-0042");
  input.run.devices[2].calibration_json = R"({"volts_per_count":7.6e-05,"cable":"W-17"})";
  CHECK(contains(render_report(input).html, "<td>W-17</td>"));
  input.laboratory.cable = "W-18";
  CHECK(contains(render_report(input).html, "<td>W-18</td>"));
}

TEST_CASE("a reference that fell due between measurement and issue does not change the report's number") {
  ReportInput input = example::example_input();
  input.laboratory.instruments[0].due = "2024-05-31";
  const Report before = render_report(input);
  input.issued = "2024-06-01";
  const Report after = render_report(input);
  CHECK(after.number == before.number);
}

TEST_CASE(
    "a signature does not change the number, and a changed report names the one that it replaces, with a reason") {
  ReportInput input = example::example_input();
  const auto data = [&] { return nlohmann::json::parse(render_report(input).json); };
  const Report draft = render_report(input);
  CHECK(draft.number == fmt::format("12-{}", draft.content_sha256.substr(0, 8)));
  input.approvals = {{12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T10:00:00Z", "", ""}};
  const Report signed_one = render_report(input);
  CHECK(signed_one.number == draft.number);
  CHECK(contains(signed_one.html, "<td>2024-06-01</td>"));
  input.laboratory.customer = "Somebody else";
  const Report changed = render_report(input);
  CHECK(changed.number != draft.number);
  CHECK(data()["replaces"] == draft.number);
  input.reason = "customer \"K & L\" corrected";
  CHECK(render_report(input).number == changed.number);
  CHECK(data()["reason"] == "customer \"K & L\" corrected");
  // Signed, it keeps the reason that it was signed with.
  input.approvals.push_back({12, changed.number, "1", "C. Chief", "2024-06-02T10:00:00Z", draft.number, "as signed"});
  input.reason = "another";
  CHECK(data()["reason"] == "as signed");
  CHECK(data()["identification"]["approvals"][1]["reason"] == "as signed");
}

TEST_CASE("the page's unit changes neither the report's number nor the method in its data") {
  ReportInput input = example::example_input();
  REQUIRE(!input.run.sequences.empty());
  input.method = {"3 repeats of 2 sweeps; a level every 4 psi, from 0 to 60 to 0 psi"};
  const auto page_in = [&](PressureUnit unit) {
    input.unit = unit;
    return render_report(input);
  };
  const Report kpa = page_in(PressureUnit::kKilopascal), psi = page_in(PressureUnit::kPsi);
  CHECK(kpa.number == psi.number);
  CHECK(nlohmann::json::parse(psi.json)["identification"]["method"][0] == input.method[0]);
}

TEST_CASE("retries, voids and flags are in the report, also when there were none") {
  ReportInput input = example::example_input();
  const std::string page = render_report(input).html;
  for (const char* part : {"1 (12 frames)", "3 of 3310", "2 dwell, 1 retried", "2.1 kPa (0.31 psi)", "22.9 to 23.2 °C"})
    CHECK(contains(page, part));
  input.history = {};
  input.history.loaded = true;
  CHECK(contains(render_report(input).html, "0 (0 frames)"));
}
