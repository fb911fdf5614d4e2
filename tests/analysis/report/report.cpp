// The report as a document: same bytes, well-formed, nothing loaded or run, banner, fields, escaping.
#include "analysis/report/report.h"

#include <catch2/catch.hpp>
#include <limits>
#include <set>

#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

TEST_CASE("the report of one input is always the same bytes, of a sensible size, well-formed and inert") {
  const ReportInput input = example::example_input();
  const Report first = render_report(input), second = render_report(input);
  CHECK(first.html == second.html);
  CHECK(first.number == second.number);
  CHECK(first.html.size() > 150'000);
  CHECK(first.html.size() < 2'000'000);
  require_well_formed(first.html);
  require_inert(first.html);
  CHECK_FALSE(contains(first.html, "http:"));
  CHECK_FALSE(contains(first.html, "https:"));
  CHECK(contains(first.html, "<html lang=\"en\">"));
  CHECK(count(first.html, "<svg ") == count(first.html, "<svg role=\"img\""));
  CHECK(count(first.html, "<svg ") == count(first.html, "</title>") - 1);
  CHECK(count(first.html, "<table") == count(first.html, "<caption>"));
  for (const std::string& tag : tags_of(first.html)) {
    if (tag == "th" || (tag.starts_with("th ") && !contains(tag, "scope="))) FAIL_CHECK("a head cell without scope");
  }
}

TEST_CASE("the report number is run number and eight hex digits of the content") {
  ReportInput input = example::example_input();
  const std::string number = render_report(input).number;
  CHECK(number.starts_with("12-"));
  CHECK(number.size() == 11);
  CHECK(number.find_first_not_of("0123456789abcdef", 3) == std::string::npos);

  SECTION("wall-clock times, UUID, host and notes are not content; neither is the run's number") {
    input.run.run = 99;
    for (db::VerdictRecord& verdict : input.verdicts) verdict.run = 99;
    input.run.uuid = "another";
    input.run.host = "another";
    input.run.started_utc = "2031-01-01T00:00:00Z";
    input.run.ended_utc = "2031-01-01T01:00:00Z";
    input.sensor->note = "another";
    input.held_out[0].run.started_utc = "2031-01-02T00:00:00Z";
    input.history.earlier_seating_run = 98;
    CHECK(render_report(input).number == "99-" + number.substr(3));
  }
  SECTION("figures are content") {
    input.evaluation.mean_error_psi += 1e-9;
    CHECK(render_report(input).number != number);
  }
  SECTION("names are content") {
    input.run.operator_name = "B. Operator";
    CHECK(render_report(input).number != number);
  }
  SECTION("verdicts are content") {
    input.verdicts[0].verdict = "fail";
    CHECK(render_report(input).number != number);
  }
  SECTION("a single taxel's parameter is content") {
    ModelTaxel& changed = input.fit.taxels[99];
    ElamModel elam = *elam_of(changed);
    elam.parameters.alpha_d += 1e-6;
    changed.fit.model = std::make_shared<ElamHysteresis>(std::move(elam));
    CHECK(render_report(input).number != number);
  }
}

TEST_CASE("banner, running head and verdicts say simulated exactly when the run is simulated") {
  ReportInput input = example::example_input();
  const std::string simulated = render_report(input).html;
  CHECK(count(simulated, "class=\"banner\"") == 1);
  CHECK(contains(simulated, "content: \"SIMULATED DEVICES"));
  CHECK(contains(simulated, "</span> simulated pass</span>"));
  CHECK(contains(simulated, "</span> simulated fail</span>"));
  CHECK_FALSE(contains(simulated, "</span> pass</span>"));
  CHECK_FALSE(contains(simulated, "</span> fail</span>"));

  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  for (db::DeviceRecord& device : input.run.devices) device.origin = "hardware";
  for (HeldOut& held_out : input.held_out) {
    for (db::DeviceRecord& device : held_out.run.devices) device.origin = "hardware";
  }
  const std::string real = render_report(input).html;
  CHECK_FALSE(contains(real, "class=\"banner\""));
  CHECK_FALSE(contains(real, "SIMULATED"));
  CHECK_FALSE(contains(real, "simulated pass"));
  CHECK(contains(real, "<span class=\"sign\">✓</span> pass</span>"));
  CHECK(contains(real, "<span class=\"sign\">✗</span> fail</span>"));

  input.held_out[1].run.origin = "simulated";
  CHECK(contains(render_report(input).html, "class=\"banner\""));
}

TEST_CASE("verdicts that are neither pass nor fail carry a triangle and their own word") {
  ReportInput input = example::example_input();
  input.run.origin = "imported";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "imported";
  for (db::VerdictRecord& verdict : input.verdicts) verdict.verdict = "pass";
  input.verdicts[0].verdict = "conditional pass";
  CHECK(contains(render_report(input).html,
                 "All requirements together: <span class=\"doubt\"><span class=\"sign\">▲</span> conditional pass"));
  input.verdicts[1].verdict = "inconclusive";
  CHECK(contains(render_report(input).html,
                 "All requirements together: <span class=\"doubt\"><span class=\"sign\">▲</span> inconclusive"));
  input.verdicts[2].verdict = "fail";
  CHECK(contains(render_report(input).html,
                 "All requirements together: <span class=\"fail\"><span class=\"sign\">✗</span> fail"));
  CHECK(contains(render_report(input).html, "Judged on: own run (calibration data). "));
  for (db::VerdictRecord& verdict : input.verdicts) verdict.run = 13;
  CHECK(contains(render_report(input).html, "Judged on: held-out run. "));
  input.verdicts.clear();
  CHECK(contains(render_report(input).html, "No tolerance limits were given"));
}

TEST_CASE("missing typed fields are not stated, never an empty cell") {
  ReportInput input = example::example_input();
  const std::size_t before = count(render_report(input).html, ">not stated<");
  CHECK(before >= 7);  // cable, laboratory, place, customer, environment, date of issue, authorised by
  input.run.operator_name.clear();
  input.run.purpose = "  ";
  input.sensor.reset();
  const std::string page = render_report(input).html;
  CHECK(count(page, ">not stated<") == before + 4);  // operator, purpose, sensor type, note
  CHECK(contains(page, "<th scope=\"row\">operator</th><td>not stated</td>"));
  CHECK(contains(page, "not issued by an accredited laboratory"));
  CHECK_FALSE(contains(page, "<td></td><td>not stated"));
}

TEST_CASE("a run without models has a report that names what is missing") {
  ReportInput input = example::example_input();
  input.fit = {};
  input.evaluation = {};
  input.held_out.clear();
  input.verdicts.clear();
  const std::string page = render_report(input).html;
  require_well_formed(page);
  CHECK(count(page, "no models were made from this run") == 6);
  CHECK(contains(page, "16 rows × 16 columns"));
  CHECK_FALSE(contains(page, "0.00\u00A0kPa"));
}

TEST_CASE("pressure is not independently traceable unless a reference of its own took part") {
  ReportInput input = example::example_input();
  CHECK_FALSE(contains(render_report(input).html, "ressure not independently traceable"));
  SECTION("no reference") { input.run.devices.erase(input.run.devices.begin() + 1); }
  SECTION("the regulator entered twice") {
    input.run.devices[1].model = input.run.devices[0].model;
    input.run.devices[1].serial = input.run.devices[0].serial;
  }
  CHECK(count(render_report(input).html, "ressure not independently traceable") == 3);  // once in the data
}

TEST_CASE("an empty input still makes a well-formed report") {
  ReportInput input;
  input.run.origin = "imported";
  const Report report = render_report(input);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK(contains(report.html, "not available"));
  CHECK_FALSE(contains(report.html, ">nan"));
}

TEST_CASE("markup in any text field stays text") {
  const std::string hostile =
      GENERATE(as<std::string>{}, "</script><img src=x onerror=\"alert(1)\">", "'\" onmouseover='alert(1)' x=\"",
               "]]><!-- --><![CDATA[ & &amp; &#x3c;script&#x3e;",
               std::string("a\x01\x1b\x7f\0b\xff\xfe\xed\xa0\x80\xc0\xaf", 14),
               "\xe2\x80\xae gnihton \xef\xbf\xbe</style></title></svg>", "{{}} {0} %s \\u003c/script\\u003e",
               std::string(3000, 'W'));
  ReportInput input = example::example_input();
  const auto spoil = [&](db::RunRecord& run) {
    for (std::string* field :
         {&run.uuid,          &run.state,          &run.reason,         &run.operator_name,   &run.purpose,
          &run.sensor_serial, &run.scanner_serial, &run.bench_id,       &run.bench_toml,      &run.bench_sha256,
          &run.sensor_toml,   &run.sensor_sha256,  &run.overrides_json, &run.program_version, &run.git_commit,
          &run.build_id,      &run.host,           &run.time_zone,      &run.started_utc,     &run.ended_utc,
          &run.content_sha256}) {
      *field = hostile;
    }
    for (db::SequenceRecord& sequence : run.sequences) sequence.name = sequence.recipe_sha256 = hostile;
    for (db::DeviceRecord& device : run.devices) {
      for (std::string* field :
           {&device.role, &device.model, &device.serial, &device.firmware, &device.origin, &device.calibration_json}) {
        *field = hostile;
      }
    }
  };
  spoil(input.run);
  input.run.devices[0].calibration_json = "{\"<b onclick='x'>\":\"</td><script>alert(1)</script>\",\"n\":[\"<i>\"]}";
  for (HeldOut& held_out : input.held_out) {
    spoil(held_out.run);
    held_out.title = hostile;
  }
  *input.sensor = {hostile, hostile, hostile, hostile, hostile, hostile, hostile};
  for (Trace& trace : input.evaluation.traces) trace.sequence = hostile;
  for (db::VerdictRecord& verdict : input.verdicts) {
    for (std::string* field : {&verdict.criterion, &verdict.scope, &verdict.unit, &verdict.rule, &verdict.verdict,
                               &verdict.limits_toml, &verdict.limits_sha256}) {
      *field = hostile;
    }
  }
  input.program_version = input.issued = input.reason = hostile;
  input.method.assign(input.run.sequences.size(), hostile);
  Laboratory& lab = input.laboratory;
  for (std::string* field : {&lab.laboratory, &lab.address, &lab.place, &lab.accreditation, &lab.customer,
                             &lab.customer_address, &lab.order, &lab.received, &lab.condition, &lab.cable,
                             &lab.mounting, &lab.medium, &lab.environment, &lab.deviations, &lab.remarks, &lab.sha256})
    *field = hostile;
  lab.instruments = {{hostile, hostile, hostile, hostile, hostile, hostile}};
  RunHistory& history = input.history;
  history.events = {{1.0, hostile, hostile}};
  history.voids = {{hostile, 0, 0, 0, hostile}};
  history.flags = {{hostile, 1}};
  history.surroundings = {{hostile, 1.0, 2.0, 3}};
  history.checks = {{1, 0, "seating", hostile, hostile, {}},
                    {1, 0, "seating", "fail", "{\"findings\":[{\"text\":\"<img onerror=1>\"}]}", {}}};
  history.time_spent = hostile;
  for (TaxelHealth& finding : input.health.findings) finding.state = finding.reason = hostile;
  for (RawLoop& loop : input.behaviour.loops) loop.name = hostile;
  for (ZeroReturn& zero : input.behaviour.zero_returns) zero.sequence = hostile;
  for (Creep& creep : input.behaviour.creep) creep.sequence = hostile;
  input.approvals = {{12, hostile, hostile, hostile, hostile, hostile, hostile}};
  input.further = {input.run};
  const Report report = render_report(input);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK_FALSE(contains(report.html, "<img"));
  CHECK_FALSE(contains(report.html, "]]>"));
  CHECK_FALSE(contains(report.html, "\xe2\x80\xae"));
  CHECK(count(report.html, "<h2 ") == 16);
}
