// The report as a document: the same each time, well-formed, nothing loaded or run, banner, number, escaping, sections.
#include "analysis/report/report.h"

#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/analysis/report/report_example_full.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

TEST_CASE("the report of one input is always the same bytes, well-formed, inert and titled throughout") {
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

TEST_CASE("the report number is run number and eight hex digits of the content") {
  ReportInput input = example::example_input();
  const std::string number = render_report(input).number;
  CHECK(number.starts_with("12-"));
  CHECK(number.size() == 11);
  CHECK(number.find_first_not_of("0123456789abcdef", 3) == std::string::npos);

  const auto other = [&](auto change) {
    ReportInput changed = input;
    change(changed);
    return render_report(changed).number != number;
  };
  CHECK(other([](ReportInput& i) { i.evaluation.mean_error_psi += 1e-9; }));
  CHECK(other([](ReportInput& i) { i.run.operator_name = "B. Operator"; }));
  CHECK(other([](ReportInput& i) { i.judgement.figures[0].verdict = Verdict::kFail; }));
  CHECK(other([](ReportInput& i) {
    ElamModel elam = *elam_of(i.fit.taxels[99]);
    elam.parameters.alpha_d += 1e-6;
    i.fit.taxels[99].fit.model = std::make_shared<ElamHysteresis>(std::move(elam));
  }));

  // Wall-clock times, UUID, host and notes are not content; neither is the run's number.
  input.run.run = 99;
  for (JudgedFigure& figure : input.judgement.figures) figure.run = 99;
  conclude(input.judgement);
  input.run.uuid = "another";
  input.run.host = "another";
  input.run.started_utc = "2031-01-01T00:00:00Z";
  input.run.ended_utc = "2031-01-01T01:00:00Z";
  input.sensor->note = "another";
  input.held_out[0].run.started_utc = "2031-01-02T00:00:00Z";
  input.history.earlier_seating_run = 98;
  CHECK(render_report(input).number == "99-" + number.substr(3));
}

TEST_CASE("banner, running head and verdicts say simulated exactly when the run is simulated") {
  ReportInput input = example::example_input();
  const std::string simulated = render_report(input).html;
  CHECK(count(simulated, "class=\"banner\"") == 1);
  CHECK(contains(simulated, "content: \"SIMULATED DEVICES"));
  CHECK(contains(simulated, "simulated pass"));

  input.run.origin = "hardware";
  for (HeldOut& held_out : input.held_out) held_out.run.origin = "hardware";
  const std::string real = render_report(input).html;
  CHECK_FALSE(contains(real, "class=\"banner\""));
  CHECK_FALSE(contains(real, "SIMULATED"));
  CHECK_FALSE(contains(real, "simulated pass"));

  input.held_out[1].run.origin = "simulated";
  CHECK(contains(render_report(input).html, "class=\"banner\""));
}

TEST_CASE("a run without models and an empty input have well-formed reports") {
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
  for (JudgedFigure& figure : input.judgement.figures)
    figure.limits_sha256 = figure.u.basis = figure.u.missing = hostile;
  Judgement& judgement = input.judgement;
  judgement.limits_sha256 = judgement.limits_name = judgement.limits_toml = hostile;
  judgement.void_counted = {{3, hostile, hostile, hostile}};
  judgement.remarks = {{Remark::Kind::kVoidCounted, judgement.void_counted.front()}};
  judgement.untraced = Untraced{.overdue_since = hostile};
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

TEST_CASE("a report's sections stand in the order of its contents, whatever of it there is") {
  ReportInput input = example::full_input();
  for (int less = 0; less < 3; ++less) {
    const std::string page = render_report(input).html;
    std::size_t at = 0, sections = 0;
    const std::size_t from = page.find("<nav"), to = page.find("</nav>");
    for (std::size_t entry = page.find("href=\"#", from); entry < to; entry = page.find("href=\"#", entry + 1)) {
      const std::string id = page.substr(entry + 7, page.find('"', entry + 7) - entry - 7);
      INFO(id);
      at = page.find("<h2 id=\"" + id + "\"", at);
      REQUIRE(at != std::string::npos);
      ++sections;
    }
    CHECK(sections == 16);
    if (less == 0) input.evaluation = {};
    if (less == 1) input.fit = {};
  }
}

TEST_CASE("a report's data: one member for each section that has data of its own, in the order of the page") {
  const auto json = nlohmann::ordered_json::parse(render_report(example::full_input()).json);
  std::vector<std::string> members;
  for (const auto& section : json["sections"].items()) members.push_back(section.key());
  CHECK(members ==
        std::vector<std::string>{"health", "raw", "models", "compensation", "studies", "objects", "uncertainty"});
  CHECK(json["schema"] == "tactbench.report");
  CHECK(json["version"] == 2);
}

TEST_CASE("values that are not numbers are null in the JSON, and none is printed as such") {
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  ReportInput input = example::example_input();
  Evaluation& e = input.evaluation;
  e.mean_error_psi = e.hysteresis_max_fs = e.levels[3].comp_distance = no_number;
  e.max_error_psi = std::numeric_limits<double>::infinity();
  e.traces[0].model_v[5] = e.traces[0].pressure_psi[9] = no_number;
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
  CHECK(results["traces"][0]["model_v"][5].is_null());
  CHECK(results["verdicts"][0]["value"].is_null());
  CHECK(results["taxel_mean_error_psi"][37].is_null());
  CHECK(report.html.find("nan") == std::string::npos);
  CHECK(report.html.find("\"inf") == std::string::npos);
}
