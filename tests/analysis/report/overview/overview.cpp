// Pages on several runs: well-formed, inert, the JSON's figures, outliers, ranks.
#include "analysis/report/overview/overview.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

ReportInput numbered(std::int64_t run, const std::string& sensor, double error) {
  ReportInput input = example::example_input();
  input.run.run = run;
  input.run.sensor_serial = sensor;
  input.held_out.clear();
  input.evaluation.mean_error_psi = error;
  input.verdicts[0].value = error;
  input.verdicts[0].verdict = error <= 1.0 ? "pass" : "fail";
  input.verdicts.resize(1);
  return input;
}

nlohmann::json json_of(const Report& report) { return nlohmann::json::parse(report.json); }

}  // namespace

TEST_CASE("modified z-scores: known values, no scores of few or equal ones") {
  const std::vector<double> scores = modified_z_scores({1, 2, 3, 4, 5, 100});
  CHECK(scores[5] == Approx(0.6745 * (100 - 3.5) / 1.5));  // median 3.5, deviations 0.5 0.5 1.5 1.5 2.5 96.5
  CHECK(std::isnan(modified_z_scores({1, 2, 3, 9})[3]));
  CHECK(std::isnan(modified_z_scores({1, 1, 1, 1, 7})[4]));
  CHECK(std::isnan(modified_z_scores({1, 2, 3, 4, 5, std::nan("")})[5]));
}

TEST_CASE("a comparison of two runs is one inert page with the differences of its figures") {
  ReportInput first = numbered(3, "S-1", 0.5), second = numbered(4, "S-1", 0.75);
  first.held_out.push_back({"as found", second.run, second.evaluation});
  first.held_out.front().evaluation.mean_error_psi = 1.25;
  const Report report = render_comparison(first, second);
  CHECK(report.html == render_comparison(first, second).html);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK(report.number.starts_with("3-4-"));
  CHECK(contains(report.html, "One sensor at two times"));
  CHECK(contains(report.html, "(1.250\u00A0psi)"));  // as found
  CHECK(
      contains(report.html,
               "<td class=\"n\">3.45 (0.500)</td><td class=\"n\">5.17 (0.750)</td><td class=\"n\">1.72 (0.250)</td><td "
               "class=\"n\">50.0</td>"));
  CHECK(json_of(report)["second"]["figures"]["mean_error_psi"] == 0.75);
  CHECK(json_of(report)["output_ratio"][0] == Approx(1.0));
  CHECK(json_of(report)["output_ratio"][37].is_null());
  second.run.sensor_serial = "S-2";
  CHECK(contains(render_comparison(first, second).html, "Two sensors"));
  CHECK(render_comparison(first, second).number != report.number);
  second.run.uuid = second.run.started_utc = "another";
  CHECK_FALSE(contains(render_comparison(first, second).html, "as left"));
}

TEST_CASE("a batch page counts, ranks, marks outliers and draws limits") {
  std::vector<ReportInput> runs;
  for (int i = 0; i < 7; ++i) runs.push_back(numbered(10 + i, fmt::format("S-{}", i), 0.50 + 0.01 * i));
  runs.push_back(numbered(20, "</td><script>", 3.0));
  const Report report = render_batch(runs);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK(report.html == render_batch(runs).html);
  CHECK(contains(report.html, "7 of 8 sensors, 87.5 %"));
  CHECK(contains(report.html, "&lt;script&gt;, run 20: corrected: mean absolute error"));
  CHECK(report.html.find("<th scope=\"row\">S-0</th>") < report.html.find("<th scope=\"row\">S-6</th>"));
  CHECK(count(report.html, "corrected: mean absolute error, kPa, number of runs</title>") == 1);
  CHECK(contains(report.html, ">tolerance limit</text>"));
  CHECK(json_of(report)["content"].size() == 8);
  for (ReportInput& run : runs) run.verdicts.clear();
  CHECK(contains(render_batch(runs).html, "not assessed: no tolerance limits were given"));
  runs.resize(3);
  CHECK(contains(render_batch(runs).html, "not assessed: fewer than five runs"));
}

TEST_CASE("runs without models, loops or noise are compared and listed as far as they go") {
  ReportInput bare;
  bare.run.run = 5;
  bare.run.origin = "hardware";
  require_well_formed(render_comparison(bare, bare).html);
  const Report batch = render_batch({bare, numbered(6, "S-1", 0.4)});
  require_well_formed(batch.html);
  CHECK(json_of(batch)["content"][0]["figures"]["mean_error_psi"].is_null());
}
