// What the report says of itself, of instruments and of the run's way: certificate, due dates, signature, deviations.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <set>

#include "analysis/report/report.h"
#include "tests/analysis/report_example.h"
#include "tests/analysis/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

TEST_CASE("a certificate needs an accreditation number, real data and a traceable pressure") {
  ReportInput input = example::example_input();
  input.laboratory.accreditation = "D-K-00000-01";
  CHECK_FALSE(contains(render_report(input).html, "ertificate</h1>"));  // simulated
  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  const std::string page = render_report(input).html;
  CHECK(contains(page, "<h1>Calibration certificate</h1>"));
  CHECK(contains(page, "Issued under accreditation D-K-00000-01."));
  CHECK_FALSE(contains(page, "not issued by an accredited"));
  SECTION("no number") { input.laboratory.accreditation.clear(); }
  SECTION("no reference") { input.run.devices.erase(input.run.devices.begin() + 1); }
  CHECK(contains(render_report(input).html, "<h1>Calibration report</h1>"));
  CHECK(contains(render_report(input).html, "Not issued by an accredited laboratory."));
}

TEST_CASE("an instrument that was overdue when the run was made is named so, in words") {
  ReportInput input = example::example_input();  // due 2024-05-01, run of 2024-05-06
  const std::string page = render_report(input).html;
  CHECK(contains(page, "OVERDUE since 2024-05-01 when the run was made"));
  CHECK(contains(page, "certificate: D-K 17, C-2024-18"));  // what was typed stands before what the run stored
  CHECK_FALSE(contains(page, "certificate: C-2024-17"));
  input.laboratory.instruments[0].due = "2024-05-06";  // on its last day
  CHECK_FALSE(contains(render_report(input).html, "OVERDUE"));
  input.laboratory.instruments[0].due.clear();
  CHECK(contains(render_report(input).html, "due: not stated"));
}

TEST_CASE("a signature does not change the number, and a changed report names the one that it replaces") {
  ReportInput input = example::example_input();
  const Report draft = render_report(input);
  CHECK(contains(draft.html, "nobody has signed"));
  CHECK(draft.number == fmt::format("12-{}", draft.content_sha256.substr(0, 8)));
  input.approvals = {{12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T10:00:00Z", ""}};
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

TEST_CASE("the cable is the one that was typed, else the one stored with the scanner") {
  ReportInput input = example::example_input();
  input.run.devices[2].calibration_json = R"({"volts_per_count":7.6e-05,"cable":"W-17"})";
  CHECK(contains(render_report(input).html, "<th scope=\"row\">cable</th><td>W-17</td>"));
  input.laboratory.cable = "W-18";
  CHECK(contains(render_report(input).html, "<th scope=\"row\">cable</th><td>W-18</td>"));
}

TEST_CASE("retries, voids, flags and surroundings stand among the deviations, also when there were none") {
  ReportInput input = example::example_input();
  const std::string page = render_report(input).html;
  CHECK(contains(page, "branches void and done again</th><td>1 (12 frames)"));
  CHECK(contains(page, "3 of 3310: 2 dwell, 1 retried"));
  CHECK(contains(page, "went back by 0.31 psi"));
  CHECK(contains(page, "temperature measured: 22.9 to 23.2 °C, 4 readings"));
  CHECK(contains(page, "row 3 answers weakly"));
  CHECK(contains(page, "rows 3 and 4 stand in each other’s place"));
  input.history = {};
  input.history.loaded = true;
  CHECK(contains(render_report(input).html, "branches void and done again</th><td>0 (0 frames)"));
}
