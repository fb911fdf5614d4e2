// Pages on several runs: figures of a run, differences, outliers, ranks, one row per sensor; well-formed and inert.
#include "analysis/report/overview/overview.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/report/overview/overview_figures.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/support/judged_figures.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

ReportInput numbered(std::int64_t run, const std::string& sensor, double error, const std::string& verdict = "pass") {
  ReportInput input = example::example_input();
  input.run.run = run;
  input.run.sensor_serial = sensor;
  input.run.started_utc = fmt::format("2024-05-{:02}T00:00:00Z", run);
  input.held_out.clear();
  input.evaluation.mean_error_psi = error;
  input.judgement.figures.resize(verdict.empty() ? 0 : 1);
  if (!verdict.empty()) input.judgement.figures[0].verdict = verdict_from(verdict).value();
  conclude(input.judgement);
  return input;
}

nlohmann::json json_of(const Report& report) { return nlohmann::json::parse(report.json); }

RawLoop mean_loop_of(std::vector<double> up, std::vector<double> down) {
  RawLoop loop;
  loop.name = "mean";
  loop.hysteresis_max = 0.25554;
  loop.hysteresis_mean = 0.10554;
  loop.up_v = std::move(up);
  loop.down_v = std::move(down);
  return loop;
}

// A run of two taxels on three levels.
ReportInput seen_run(std::int64_t run, const char* sensor) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = run;
  input.run.origin = "hardware";
  input.run.sensor_serial = sensor;
  input.run.started_utc = "2024-05-06T07:08:09Z";
  input.health.rows = 1;
  input.health.columns = 2;
  input.health.high_v = {3.0, 3.1};
  input.health.noise_v = {0.001, 0.002};
  input.health.median_noise_v = 0.0012344;
  input.health.findings = {{0, "noisy", "", false}, {1, "dead", "", true}};
  input.behaviour.pressure_psi = {0.0, 40.0, 60.0};
  input.behaviour.full_scale_v = 3.45644;
  input.behaviour.loops = {mean_loop_of({0.0, 2.0, 3.0}, {0.0, 2.5, 3.0})};
  input.behaviour.equilibration_psi = 40.0;
  input.behaviour.gain = {0.9, 1.2};
  input.evaluation.levels.resize(1);
  input.evaluation.mean_error_psi = 0.51244;
  input.evaluation.worst_taxel_mean_error_psi = 1.23444;
  input.evaluation.raw_distance = 0.11124;
  input.evaluation.comp_distance_of_mean = 0.01224;
  input.evaluation.comp_distance = 0.01334;
  input.history.loaded = true;
  input.history.events = {{1.0, "attempt", ""}, {2.0, "pause", ""}, {3.0, "attempt", ""}};
  input.history.voids = {{"up", 0, 0, 0, ""}};
  return input;
}

const OverviewFigure& overview_figure(const std::string& key) {
  for (const OverviewFigure& figure : overview_figures())
    if (figure.key == key) return figure;
  FAIL("no figure " << key);
  return overview_figures().front();
}

double figure_of(const char* key, const ReportInput& input) { return overview_figure(key).value(input); }

}  // namespace

TEST_CASE("overview values: match hand-computed values, and are NaN if the run has none") {
  ReportInput input = seen_run(3, "S");
  const std::map<std::string, double> expected = {
      {"excluded_taxels", 1.0},        {"median_noise_v", 0.0012344},
      {"full_scale_v", 3.45644},       {"hysteresis_max_fs", 0.25554},
      {"hysteresis_mean_fs", 0.10554}, {"gain_std", std::sqrt(0.01 + 0.04)},
      {"mean_error_psi", 0.51244},     {"worst_taxel_mean_error_psi", 1.23444},
      {"raw_distance_fs", 0.11124},    {"comp_distance_of_mean_fs", 0.01224},
      {"comp_distance_fs", 0.01334},   {"retries", 3.0}};
  CHECK(overview_figures().size() == expected.size());
  for (const OverviewFigure& figure : overview_figures()) {
    INFO(figure.key);
    CHECK(figure.value(input) == Approx(expected.at(figure.key)));
    CHECK(std::isnan(figure.value(ReportInput{})));
  }
  input.behaviour.gain = {std::nan(""), 0.9, 1.2, std::nan(""), 1.0};
  CHECK(figure_of("gain_std", input) == Approx(std::sqrt(0.05 / 2.0)));
  input.behaviour.gain = {std::nan(""), 0.9};
  CHECK(std::isnan(figure_of("gain_std", input)));
  CHECK(plotted_figure(overview_figure("mean_error_psi"), 2.0, PressureUnit::kKilopascal) == Approx(13.789514586));
}

TEST_CASE("overview limit: is that of the first verdict on the value's criterion, else NaN") {
  ReportInput input = seen_run(3, "S");
  for (const double limit : {0.015, 0.025}) {
    JudgedFigure& figure = input.judgement.figures.emplace_back();
    figure.criterion = Criterion::kDistanceOfMean;
    figure.limit = limit;
  }
  CHECK(limit_of(overview_figure("comp_distance_of_mean_fs"), input) == 0.015);
  CHECK(std::isnan(limit_of(overview_figure("mean_error_psi"), input)));
  CHECK(std::isnan(limit_of(overview_figure("gain_std"), input)));
}

TEST_CASE("modified z-scores: match known values, and are NaN for few or equal values") {
  const std::vector<double> scores = modified_z_scores({1, 2, 3, 4, 5, 100});
  CHECK(scores[5] == Approx(0.6745 * (100 - 3.5) / 1.5));  // median 3.5, deviations 0.5 0.5 1.5 1.5 2.5 96.5
  CHECK(modified_z_scores({1, 2, 3, 4, 10})[0] == Approx(-0.6745 * 2));  // of five, median 3, deviations 2 1 0 1 7
  CHECK(modified_z_scores({1, 2, 3, 4, 10})[2] == 0.0);
  CHECK(std::isnan(modified_z_scores({1, 2, 3, 9})[3]));
  CHECK(std::isnan(modified_z_scores({1, 1, 1, 1, 7})[4]));
  CHECK(std::isnan(modified_z_scores({1, 2, 3, 4, 5, std::nan("")})[5]));
}

TEST_CASE("run comparison: is one inert page with the differences of the runs' values") {
  ReportInput first = numbered(3, "S-1", 0.5), second = numbered(4, "S-1", 0.75);
  const Report report = render_comparison(first, second);
  CHECK(report.html == render_comparison(first, second).html);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK(report.number.starts_with("3-4-"));
  CHECK(contains(report.html, ">1.72<"));  // kPa
  CHECK(json_of(report)["second"]["figures"]["mean_error_psi"] == 0.75);
  CHECK(json_of(report)["output_ratio"][0] == Approx(1.0));
  CHECK(json_of(report)["output_ratio"][37].is_null());
  second.run.sensor_serial = "S-2";
  CHECK(render_comparison(first, second).number != report.number);
  second.run.origin = "hardware";
  CHECK(contains(render_comparison(first, second).html, "class=\"banner\""));
}

TEST_CASE("run comparison: output ratios per taxel need a common level within 0.5 psi") {
  const ReportInput first = seen_run(3, "S-1");
  ReportInput second = seen_run(4, "S-2");
  second.behaviour.loops = {mean_loop_of({0.0, 3.0, 4.0}, {0.0, 3.5, 4.0})};
  second.behaviour.gain = {0.9, 0.6};
  const auto ratio = [&] {
    const auto json = json_of(render_comparison(first, second))["output_ratio"];
    return json.empty() ? 0.0 : json[1].get<double>();
  };
  CHECK(ratio() == Approx(0.75));  // 3 V over 2 V, half of the gain
  for (const auto& [level, of] : {std::pair{40.49, 0.75}, {40.5, 0.0}, {39.5, 0.0}, {40.0, 0.75}}) {
    CAPTURE(level);
    second.behaviour.pressure_psi[1] = second.behaviour.equilibration_psi = level;
    CHECK(ratio() == Approx(of));
  }
  const ReportInput good = second;
  second.health.columns = 1;
  CHECK(ratio() == 0.0);
  second = good;
  second.behaviour.gain.push_back(1.0);
  CHECK(ratio() == 0.0);
  second = good;
  second.behaviour.loops.clear();
  CHECK(ratio() == 0.0);
}

TEST_CASE("batch report: ranks by verdict before error, with one row per sensor") {
  std::vector<ReportInput> named = {numbered(1, "S-fail", 0.1, "fail"),
                                    numbered(2, "S-none", 0.2, ""),
                                    numbered(3, "S-doubt", 0.3, "conditional pass"),
                                    numbered(4, "S-good", 0.5, "pass"),
                                    numbered(5, "S-better", 0.4, "pass"),
                                    numbered(6, "S-good", 0.6, "pass"),
                                    numbered(7, "S-bare", 0.1, "pass"),
                                    numbered(8, "S-bare", 0.1, "")};
  named[7].fit = {};  // newer, and without models: the run with models represents the sensor
  CHECK(batch_rows(named) == std::vector<std::size_t>{0, 1, 2, 4, 5, 6});
  const Report report = render_batch(named);
  require_well_formed(report.html);
  std::vector<std::size_t> places;
  for (const char* sensor : {"S-bare", "S-better", "S-good", "S-doubt", "S-none", "S-fail"}) {
    INFO(sensor);
    places.push_back(report.html.find(fmt::format("<span class=\"b\">{}</span>", sensor)));
    CHECK(places.back() != std::string::npos);
  }
  CHECK(std::ranges::is_sorted(places));
  CHECK(count(report.html, "<span class=\"b\">S-good</span>") == 1);
  CHECK(contains(report.html, "80.0 %"));  // four of five
  // Without a serial number each run is a separate sensor; among equal ones both are kept; a void run does not count.
  std::vector<ReportInput> two = {named[0], named[1]};
  for (ReportInput& run : two) run.run.sensor_serial.clear();
  CHECK(batch_rows(two) == std::vector<std::size_t>{0, 1});
  two = {numbered(1, "S-1", 0.1), numbered(1, "S-1", 0.2)};
  CHECK(batch_rows(two) == std::vector<std::size_t>{0, 1});
  two[0].run.void_utc = "2024-06-01T00:00:00Z";
  CHECK(batch_rows(two) == std::vector<std::size_t>{1});
}

TEST_CASE("batch report: hostile names give a well-formed inert page with every run in its data") {
  std::vector<ReportInput> runs;
  for (int i = 0; i < 7; ++i) runs.push_back(numbered(10 + i, fmt::format("S-{}", i), 0.50 + 0.01 * i));
  runs.push_back(numbered(20, "</td><script>", 3.0, "fail"));
  const Report report = render_batch(runs);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK(report.html == render_batch(runs).html);
  CHECK(contains(report.html, "87.5 %"));
  CHECK(json_of(report)["content"].size() == 8);
}

TEST_CASE("overview pages: accept runs without models, loops or noise") {
  ReportInput bare;
  bare.run.run = 5;
  bare.run.origin = "hardware";
  require_well_formed(render_comparison(bare, bare).html);
  const Report batch = render_batch({bare, numbered(6, "S-1", 0.4)});
  require_well_formed(batch.html);
  CHECK(json_of(batch)["content"][0]["figures"]["mean_error_psi"].is_null());
}
