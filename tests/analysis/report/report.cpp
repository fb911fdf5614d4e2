// The report as a document: the same each time, well-formed, nothing loaded or run, banner, escaping, issue, annexes.
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/report_facts.h"
#include "tests/analysis/report/report_example.h"

using namespace tactbench;
using namespace tactbench::analysis;

TEST_CASE("report: one input always gives the same bytes, well-formed, inert and with titles") {
  for (const ReportInput& input : {example::example_input(), example::full_input()}) {
    const Report first = render_report(input), second = render_report(input);
    CHECK(first.html == second.html);
    CHECK(first.number == second.number);
    require_well_formed(first.html);
    require_inert(first.html);
    require_titled(first.html);
    for (const char* part : {"http:", "https:", "<img"}) CHECK_FALSE(contains(first.html, part));
    for (const std::string& tag : tags_of(first.html))
      if (tag == "th" || (tag.starts_with("th ") && !contains(tag, "scope="))) FAIL_CHECK("a head cell without scope");
  }
}

TEST_CASE("report: banner and page header say simulated exactly if a run is simulated") {
  ReportInput input = example::example_input();
  const std::string simulated = render_report(input).html;
  CHECK(count(simulated, "class=\"banner\"") == 1);
  CHECK(contains(simulated, "content: \"SIMULATED DEVICES"));

  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  const std::string real = render_report(input).html;
  CHECK_FALSE(contains(real, "class=\"banner\""));
  CHECK_FALSE(contains(real, "SIMULATED"));

  input.held_out[1].run.origin = "simulated";
  CHECK(contains(render_report(input).html, "class=\"banner\""));
}

TEST_CASE("report: a run without models and an empty input give well-formed reports") {
  ReportInput input = example::example_input(), empty;
  input.fit = {};
  input.evaluation = {};
  input.held_out.clear();
  input.judgement = {};
  empty.run.origin = "imported";
  for (const ReportInput* bare : {&input, &empty}) {
    const std::string page = render_report(*bare).html;
    require_well_formed(page);
    require_inert(page);
    CHECK_FALSE(contains(page, ">nan"));
  }
}

TEST_CASE("report: markup in any text field is escaped") {
  const std::string hostile =
      GENERATE(as<std::string>{}, "</script><img src=x onerror=\"alert(1)\">", "'\" onmouseover='alert(1)' x=\"",
               "]]><!-- --><![CDATA[ & &amp; &#x3c;script&#x3e;",
               std::string("a\x01\x1b\x7f\0b\xff\xfe\xed\xa0\x80\xc0\xaf", 14),
               "\xe2\x80\xae gnihton \xef\xbf\xbe</style></title></svg>", "{{}} {0} %s \\u003c/script\\u003e",
               std::string(3000, 'W'));
  ReportInput input = example::full_input();
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
  for (JudgedFigure& figure : input.judgement.figures)
    figure.limits_sha256 = figure.u.basis = figure.u.missing = hostile;
  input.judgement.void_counted = {{1, hostile, hostile, hostile}};
  input.judgement.remarks = {{Remark::Kind::kVoidCounted, {1, hostile, hostile, hostile}}};
  input.program_version = input.issued = input.reason = hostile;
  input.method.assign(input.run.sequences.size(), hostile);
  Laboratory& lab = input.laboratory;
  for (std::string* field :
       {&lab.laboratory, &lab.address, &lab.place, &lab.accreditation, &lab.customer, &lab.customer_address, &lab.order,
        &lab.received, &lab.condition, &lab.cable, &lab.mounting, &lab.medium, &lab.environment, &lab.deviations,
        &lab.remarks, &lab.sha256, &lab.valid_until})
    *field = hostile;
  lab.instruments = {{hostile, hostile, hostile, hostile, hostile, hostile}};
  RunLog& history = input.history;
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
  input.annexes.assign(kAnnexes.begin(), kAnnexes.end());
  const Report report = render_report(input);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK_FALSE(contains(report.html, "<img"));
  CHECK_FALSE(contains(report.html, "]]>"));
  CHECK_FALSE(contains(report.html, "\xe2\x80\xae"));
}

TEST_CASE("report: annexes are printed on request, and data per taxel are in the JSON only") {
  ReportInput input = example::full_input();
  const Report six = render_report(input);
  CHECK(six.html.size() < 400'000);
  CHECK_FALSE(contains(six.html, "Annex: "));
  CHECK_FALSE(contains(six.html, "taxel_error_psi"));
  CHECK(contains(six.json, "taxel_error_psi"));
  const auto json = nlohmann::ordered_json::parse(six.json);
  CHECK((json["schema"] == "tactbench.report" && json["version"] == 3 && json["number"] == six.number));
  for (const char* name : kAnnexes) {
    input.annexes = {name};
    CHECK(contains(render_report(input).html, fmt::format("Annex: {}", name)));
  }
}

TEST_CASE("report title: a calibration needs U, a certificate also accreditation, real data and traceability") {
  ReportInput input = example::full_input();
  const auto document = [&] { return report_json(input)["document"]; };
  input.laboratory.accreditation = "D-K-00000-01";
  input.laboratory.instruments[0].due = "2025-05-01";
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
  SECTION("U is valid for no kind of history") {
    input.uncertainty->conditions[0].not_valid = "too few";
    other = "Test report";
  }
  SECTION("no uncertainty") {
    input.uncertainty.reset();
    other = "Test report";
  }
  CHECK(document() == other);
}

TEST_CASE("report: a reference has one certificate and due date in all parts, FILL-IN counts as none") {
  ReportInput input = example::full_input();  // the run says C-2024-17, the laboratory file D-K 17, C-2024-18
  input.uncertainty->reference = reference_uncertainty(input.run, input.laboratory.instruments);
  const nlohmann::json data = report_json(input);
  for (const nlohmann::json* place :
       {&data["sections"]["uncertainty"]["reading"]["reference"], &data["identification"]["run"]["devices"][1]}) {
    CHECK((*place)["certificate"] == "C-2024-17");
    CHECK((*place)["due"] == "2024-05-01");
    CHECK((*place)["overdue"] == true);
  }
  input.run.devices[0].serial = "FILL-IN";
  input.run.devices[1].calibration_json = R"({"span_psi":[0,150],"certificate":"FILL-IN","due":"soon"})";
  CHECK_FALSE(contains(render_report(input).html, "FILL-IN"));
}

TEST_CASE("report validity: ends at the laboratory's date, or the stated months after the measurement") {
  ReportInput input = example::full_input();  // measured on 2024-05-06
  CHECK(valid_until(input.laboratory, input.run.started_utc).empty());
  input.laboratory.recalibrate_after_months = 12;
  CHECK(valid_until(input.laboratory, input.run.started_utc) == "2025-05-06");
  input.run.started_utc = "2024-01-31T00:00:00Z";
  input.laboratory.recalibrate_after_months = 1;
  CHECK(valid_until(input.laboratory, input.run.started_utc) == "2024-02-29");
  input.laboratory.valid_until = "2026-01-01";
  CHECK(valid_until(input.laboratory, input.run.started_utc) == "2026-01-01");
  CHECK(contains(render_report(input).html, "2026-01-01"));
}

TEST_CASE("report: a signed draft keeps its number, and a changed report names what it replaces and why") {
  ReportInput input = example::example_input();
  const Report draft = render_report(input);
  CHECK_FALSE(contains(draft.html, signed_title_mark(draft.number) + "</title>"));
  input.approvals = {{12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T10:00:00Z", "", ""}};
  const Report issued = render_report(input);
  CHECK(issued.number == draft.number);
  CHECK(contains(issued.html, signed_title_mark(issued.number) + "</title>"));
  input.laboratory.customer = "Somebody else";
  const Report changed = render_report(input);
  CHECK(changed.number != draft.number);
  CHECK(report_json(input)["replaces"] == draft.number);
  input.reason = "customer \"K & L\" corrected";
  CHECK(render_report(input).number == changed.number);
  CHECK(report_json(input)["reason"] == input.reason);
  // Signed, it keeps the reason that it was signed with.
  input.approvals.push_back({12, changed.number, "1", "C. Chief", "2024-06-02T10:00:00Z", draft.number, "as signed"});
  input.reason = "another";
  CHECK(report_json(input)["reason"] == "as signed");
}

TEST_CASE("report: non-finite values are null in the JSON and are not printed") {
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  ReportInput input = example::example_input();
  Evaluation& e = input.evaluation;
  e.mean_error_psi = e.hysteresis_max_fs = e.levels[3].comp_distance = no_number;
  e.max_error_psi = std::numeric_limits<double>::infinity();
  e.levels[2].raw_up_v[8] = no_number;
  input.judgement.figures[0].value = no_number;
  input.fit.taxels.back().fit.j = no_number;
  e.levels[27].flat_taxels = 254;  // every fitted one: nothing observable is left
  e.levels[27].comp_distance_observable = 0.0;
  const Report report = render_report(input);
  const auto results = nlohmann::json::parse(report.json)["results"];
  CHECK(results["evaluation"]["levels"][27]["comp_distance_observable_fs"].is_null());
  CHECK(results["evaluation"]["mean_error_psi"].is_null());
  CHECK(results["evaluation"]["max_error_psi"].is_null());
  CHECK(results["verdicts"][0]["value"].is_null());
  CHECK(results["taxel_mean_error_psi"][37].is_null());
  CHECK(report.html.find("nan") == std::string::npos);
  CHECK(report.html.find("\"inf") == std::string::npos);
}

// The hash in a report's number covers every result, and no name, time or host.

TEST_CASE("report number: changes when any result changes") {
  const ReportInput input = example::full_input();
  std::set<std::string> contents = {render_report(input).content_sha256};
  const std::function<void(ReportInput&)> changes[] = {
      [](ReportInput& i) { i.evaluation.mean_error_psi += 1e-9; },
      [](ReportInput& i) { i.evaluation.levels[3].comp_distance += 1e-9; },
      [](ReportInput& i) { i.evaluation.levels[3].raw_up_v[7] += 1e-3; },
      [](ReportInput& i) { i.evaluation.taxel_mean_error_psi[7] += 1e-3; },
      [](ReportInput& i) { i.held_out[1].evaluation.max_error_psi += 1e-9; },
      [](ReportInput& i) { i.judgement.figures[0].value += 1e-9; },
      [](ReportInput& i) { i.judgement.figures[0].u.expanded = 0.1; },
      [](ReportInput& i) { i.judgement.figures[1].verdict = Verdict::kInconclusive; },
      [](ReportInput& i) { i.judgement.figures[1].run = i.held_out[0].evaluation.run; },
      [](ReportInput& i) { i.judgement.stored_worse = {i.judgement.figures[0]}; },
      [](ReportInput& i) { i.judgement.not_assessed = {Source::kCreep}; },
      [](ReportInput& i) { i.uncertainty->levels[5].error_psi[9] += 1e-2; },
      [](ReportInput& i) { i.uncertainty->conditions[0].expanded_psi[9] += 1e-2; },
      [](ReportInput& i) { i.uncertainty->conditions[0].not_valid = "too few"; },
      [](ReportInput& i) { i.uncertainty->reference.drift_psi += 1e-9; },
      [](ReportInput& i) { i.applied[0].pressure_psi[1] += 1.0; },
      [](ReportInput& i) { i.behaviour.loops[0].up_v[3] += 1e-3; },
      [](ReportInput& i) { i.behaviour.gain[3] += 1e-3; },
      [](ReportInput& i) { i.behaviour.repeatability[3].mean_up_v += 1e-9; },
      [](ReportInput& i) { i.behaviour.zero_returns[0].mean_v += 1e-9; },
      [](ReportInput& i) { i.behaviour.creep[0].per_decade += 1e-9; },
      [](ReportInput& i) { i.health.findings.pop_back(); },
      [](ReportInput& i) { i.health.noise_v[3] += 1e-3; },
      [](ReportInput& i) { i.health.swaps.clear(); },
      [](ReportInput& i) { i.more.previous->evaluation.mean_error_psi += 1e-9; },
      [](ReportInput& i) { i.more.previous->doubt = "since then"; },
      [](ReportInput& i) { i.more.contacts[0].levels[0].compensated.force_n += 1e-9; },
      [](ReportInput& i) { i.more.contacts[0].compensated_mean_error_n += 1e-9; },
      [](ReportInput& i) { i.more.studies.crosstalk.row.mean_share += 1e-9; },
      [](ReportInput& i) { i.more.studies.rate_hold.runs[0].output_max_share += 1e-9; },
      [](ReportInput& i) { i.more.studies.remount.s_share += 1e-9; },
      [](ReportInput& i) { i.more.studies.uniformity.u_share += 1e-9; },
      [](ReportInput& i) { i.fit.taxels[9].noise += 1e-9; },
      [](ReportInput& i) { i.fit.taxels[9].fit.max_error += 1e-9; },
      [](ReportInput& i) { i.history.flagged += 1; },
      [](ReportInput& i) { i.history.voids.clear(); },
      [](ReportInput& i) { i.history.checks[0].verdict = "pass"; },
      [](ReportInput& i) { i.method = {"otherwise"}; },
      [](ReportInput& i) { i.laboratory.customer = "Somebody else"; },
      [](ReportInput& i) { i.laboratory.recalibrate_after_months = 12; },
      [](ReportInput& i) { i.run.operator_name = "B. Operator"; },
      [](ReportInput& i) { i.run.devices[1].calibration_json = "{}"; },
  };
  for (const auto& change : changes) {
    ReportInput other = input;
    change(other);
    CHECK(contents.insert(render_report(other).content_sha256).second);
  }
}

TEST_CASE("report number: does not depend on run numbers, times, hosts, signatures, annexes or the pressure unit") {
  const auto named = [](std::int64_t first, const char* utc) {
    ReportInput input = example::full_input();
    for (std::size_t i = 0; i < input.held_out.size(); ++i)
      input.held_out[i].run.run = input.held_out[i].evaluation.run = first + 1 + static_cast<std::int64_t>(i);
    for (db::RunRecord* run : {&input.run, &input.held_out[0].run}) run->started_utc = run->uuid = run->host = utc;
    input.run.run = input.evaluation.run = first;
    for (JudgedFigure& figure : input.judgement.figures) figure.run = figure.model_run = first;
    input.judgement.figures[1].run = first + 2;
    input.judgement.stored_worse = {input.judgement.figures[1]};
    conclude(input.judgement);
    input.more.studies.crosstalk.run = input.more.contacts[0].run = input.more.contacts[0].mount_run = first + 30;
    input.more.studies.rate_hold.runs[0].run = first + 31;
    input.more.studies.uniformity.runs = input.more.studies.remount.runs = {first, first + 32};
    input.history.earlier_seating_run = first + 33;
    input.sensor->note = input.sensor->added_utc = utc;
    return input;
  };
  const ReportInput input = named(12, "2024-05-06T07:08:09Z");
  const Report report = render_report(input);
  CHECK(report.number == "12-" + report.content_sha256.substr(0, 8));
  ReportInput other = named(70, "2024-05-06T09:00:00Z");
  CHECK(render_report(other).content_sha256 == report.content_sha256);
  other.unit = PressureUnit::kPsi;
  other.annexes = {"maps"};
  other.reason = "a reason";
  other.approvals = {{70, "70-1", "", "C. Chief", "2024-06-01T00:00:00Z", "", ""}};
  CHECK(render_report(other).content_sha256 == report.content_sha256);
  std::swap(other.judgement.figures[0].run, other.judgement.figures[1].run);
  CHECK(render_report(other).content_sha256 != report.content_sha256);
}
