// What a report's number is a hash of: every result, and no name, time or host.
#include <catch2/catch.hpp>
#include <functional>
#include <set>

#include "tests/analysis/report/report_example_full.h"

using namespace tactbench;
using namespace tactbench::analysis;

TEST_CASE("each result is content of a report: when one changes, so does the number") {
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

TEST_CASE("names of runs, times, hosts, signatures, annexes and the page's unit are not content") {
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
