// Pages on several runs by hand: each figure of a run, rows of a comparison, ranks, outliers, distributions, loops.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/overview/overview.h"
#include "analysis/report/overview/overview_figures.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

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

std::string shown(const char* key, const ReportInput& input) {
  const OverviewFigure& figure = overview_figure(key);
  return shown_figure(figure, figure.value(input), PressureUnit::kPsi).value;
}

// A comparison's rows: first, second, difference, change.
std::string compared_figures(const std::string& name, const std::vector<std::string>& cells) {
  return row(name, cells);
}

}  // namespace

TEST_CASE("figures of a run by hand: each value as shown, and none where the run has no such figure") {
  const ReportInput input = seen_run(3, "S");
  CHECK(shown("excluded_taxels", input) == "1");
  CHECK(shown("median_noise_v", input) == "1.234");
  CHECK(shown("full_scale_v", input) == "3.456");
  CHECK(shown("hysteresis_max_fs", input) == "25.55");
  CHECK(shown("hysteresis_mean_fs", input) == "10.55");
  CHECK(shown("gain_std", input) == "22.4");  // sqrt(0.01 + 0.04)
  CHECK(shown("mean_error_psi", input) == "0.512 (3.53)");
  CHECK(shown("worst_taxel_mean_error_psi", input) == "1.234 (8.51)");
  CHECK(shown("raw_distance_fs", input) == "11.12");
  CHECK(shown("comp_distance_of_mean_fs", input) == "1.22");
  CHECK(shown("comp_distance_fs", input) == "1.33");
  CHECK(shown("retries", input) == "3");
  CHECK(overview_figures().size() == 12);
  for (const OverviewFigure& figure : overview_figures()) {
    INFO(figure.key);
    CHECK(std::isnan(figure.value(ReportInput{})));
    CHECK(shown_figure(figure, kNone, PressureUnit::kPsi).value == "–");
  }
  ReportInput other = input;
  other.behaviour.gain = {kNone, 0.9, 1.2, kNone, 1.0};
  CHECK(overview_figure("gain_std").value(other) == Approx(std::sqrt(0.05 / 2.0)));
  other.behaviour.gain = {kNone, 0.9};
  CHECK(std::isnan(overview_figure("gain_std").value(other)));
  CHECK(plotted_figure(overview_figure("mean_error_psi"), 2.0, PressureUnit::kKilopascal) == Approx(13.789514586));
  CHECK(plotted_figure(overview_figure("gain_std"), 0.25, PressureUnit::kKilopascal) == 25.0);
  CHECK(plotted_figure(overview_figure("median_noise_v"), 0.25, PressureUnit::kKilopascal) == 250.0);
  CHECK(name_of(overview_figure("mean_error_psi"), PressureUnit::kPsi) == "corrected: mean absolute error, psi (kPa)");
  CHECK(name_of(overview_figure("retries"), PressureUnit::kPsi) == "branches void and attempts after faults");
}

TEST_CASE("a figure's limit is that of the first verdict on its criterion, and none for a figure without one") {
  ReportInput input = seen_run(3, "S");
  input.verdicts = {{3, 1, "", "array", 0, 7.0, "", "", "pass", "", "", 0},
                    {3, 1, "distance_of_mean", "array", 0, 0.015, "FS", "", "pass", "", "", 0},
                    {3, 1, "distance_of_mean", "array", 0, 0.025, "FS", "", "pass", "", "", 0}};
  CHECK(limit_of(overview_figure("comp_distance_of_mean_fs"), input) == 0.015);
  CHECK(std::isnan(limit_of(overview_figure("mean_error_psi"), input)));
  CHECK(std::isnan(limit_of(overview_figure("gain_std"), input)));
}

TEST_CASE("modified z-scores by hand: five values are scored, on both sides of the median") {
  // Median 3, deviations 2, 1, 0, 1, 7: their median is 1.
  const std::vector<double> scores = modified_z_scores({1, 2, 3, 4, 10});
  CHECK(scores[0] == Approx(-0.6745 * 2));
  CHECK(scores[2] == 0.0);
  CHECK(scores[4] == Approx(0.6745 * 7));
  CHECK(std::isnan(modified_z_scores({1, 2, kNone, 4, 10})[0]));
  // Deviations 2, 1, 0, 1, 17 about 3, times two: halves of the scores' steps.
  CHECK(modified_z_scores({2, 4, 6, 8, 40})[4] == Approx(0.6745 * 34 / 2));
}

TEST_CASE("a comparison by hand: first, second, difference and change of each figure") {
  const ReportInput first = seen_run(3, "S-1");
  ReportInput second = seen_run(4, "S-1");
  second.evaluation.mean_error_psi = 0.76866;
  second.evaluation.comp_distance = 0.0;
  second.behaviour.loops[0].hysteresis_max = 0.12777;
  second.health.findings.clear();
  second.health.noise_v.clear();
  const std::string page = render_comparison(first, second).html;
  check_once(page, compared_figures("corrected: mean absolute error, psi (kPa)",
                                    {"0.512 (3.53)", "0.769 (5.30)", "0.256 (1.77)", "50.0"}));
  check_once(page, compared_figures("indication: hysteresis, maximum, % FS", {"25.55", "12.78", "−12.78", "−50.0"}));
  check_once(page,
             compared_figures("corrected: hysteresis, mean over taxels, % FS", {"1.33", "0.00", "−1.33", "−100.0"}));
  check_once(page, compared_figures("excluded taxels", {"1", "0", "−1", "−100.0"}));
  check_once(page, compared_figures("noise of the median taxel, mV", {"1.234", "–", "–", "–"}));
  const std::string back = render_comparison(second, first).html;
  check_once(back, compared_figures("excluded taxels", {"0", "1", "1", "–"}));
  check_once(page, "<th scope=\"row\">only in the first run</th><td>noisy 0, dead 1</td>");
  check_once(page, "<th scope=\"row\">only in the second run</th><td>none</td>");
  check_none(page, "as left (its own models)");
}

TEST_CASE("a comparison by hand: loops of both runs, and their ratio taxel by taxel at a common level") {
  const ReportInput first = seen_run(3, "S-1");
  ReportInput second = seen_run(4, "S-2");
  second.behaviour.loops = {mean_loop_of({0.0, 3.0, 4.0}, {0.0, 3.5, 4.0})};
  second.behaviour.gain = {0.9, 0.6};
  const auto page = [&] { return render_comparison(first, second).html; };
  const std::vector<double> x = {0.0, 40.0, 60.0, 60.0, 40.0, 0.0};
  LineChart chart{.title = "Mean external loops of the indication of the two runs",
                  .x_label = "gauge pressure",
                  .y_label = "output in V",
                  .series = {{"first: S-1, run 3", x, {0.0, 2.0, 3.0, 3.0, 2.5, 0.0}, 0},
                             {"second: S-2, run 4", x, {0.0, 3.0, 4.0, 4.0, 3.5, 0.0}, 1}},
                  .width = 682,
                  .height = 220};
  check_along(page(), chart);
  // 3 V over 2 V; gains alike and half of it: 1.5 and 0.75.
  const std::vector<double> ratios = {0.9 / 0.9 * 1.5, 0.6 / 1.2 * 1.5};
  check_once(page(), frame_map({"Output of each taxel, second run over first, at one level, pressure increasing",
                                1,
                                2,
                                ratios,
                                {0.75, 1.5},
                                180.0})
                             .value +
                         colour_bar({0.75, 1.5}, "Colour scale of the ratios", "×", 3).value);
  check_once(page(), "at " + psi(40.0, 1) + ", increasing, second over first: 0.750 to 1.500, median 1.125.");
  check_once(page(), histogram_chart({.title = "Ratio of outputs, number of taxels",
                                      .x_label = "second over first",
                                      .y_label = "taxels",
                                      .values = ratios,
                                      .limit = std::nullopt,
                                      .limit_name = {},
                                      .width = 400,
                                      .height = 215})
                         .value);
  const auto ratio = [&] {
    const auto json = nlohmann::json::parse(render_comparison(first, second).json)["output_ratio"];
    return json.empty() ? 0.0 : json[1].get<double>();
  };
  CHECK(ratio() == Approx(0.75));
  second.behaviour.pressure_psi[1] = second.behaviour.equilibration_psi = 40.49;
  CHECK(ratio() == Approx(0.75));
  second.behaviour.pressure_psi[1] = second.behaviour.equilibration_psi = 40.5;
  CHECK(ratio() == 0.0);
  second.behaviour.pressure_psi[1] = second.behaviour.equilibration_psi = 39.5;
  CHECK(ratio() == 0.0);
  check_once(page(), "Taxel by taxel: not available");
  second.behaviour.pressure_psi[1] = second.behaviour.equilibration_psi = 40.0;
  second.health.columns = 1;
  CHECK(ratio() == 0.0);
  second.health.columns = 2;
  second.behaviour.gain.push_back(1.0);
  CHECK(ratio() == 0.0);
  second.behaviour.gain = {0.9, 1.2};
  check_once(page(), colour_bar({1.5, 1.501}, "Colour scale of the ratios", "×", 3).value);
  second.behaviour.loops.clear();
  CHECK(ratio() == 0.0);
  chart.series.pop_back();
  check_along(page(), chart);
  check_once(render_comparison(second, second).html, "<p>Loops: not available</p>");
  chart.series[0].name = "second: S-1, run 3";
  check_along(render_comparison(second, first).html, chart);
}

TEST_CASE("a comparison by hand: as found and as left of the second run, and both runs' own words") {
  ReportInput first = seen_run(3, "S-1"), second = seen_run(4, "S-1");
  first.run.sequences = {{0, "down", "", "", 5, 1}, {1, "up", "", "", 3, 1}};
  Evaluation found = second.evaluation;
  found.mean_error_psi = 0.91114;
  found.max_error_psi = 3.3334;
  found.worst_taxel_mean_error_psi = 1.9994;
  found.comp_distance = 0.02224;
  found.comp_distance_of_mean = 0.03334;
  first.held_out = {{"as found", second.run, found}};
  second.evaluation.max_error_psi = 2.2224;
  std::string page = render_comparison(first, second).html;
  check_once(page, row("mean absolute error", {psi(0.91114, 3), psi(0.51244, 3)}));
  check_once(page, row("maximum absolute error", {psi(3.3334, 2), psi(2.2224, 2)}));
  check_once(page, row("mean absolute error of the worst taxel", {psi(1.9994, 3), psi(1.23444, 3)}));
  check_once(page, row("hysteresis, mean over taxels, % FS", {"2.22", "1.33"}));
  check_once(page, row("hysteresis of the mean of all pressures, % FS", {"3.33", "1.22"}));
  check_once(page, "<th scope=\"row\">recipes</th><td>down (5 ×), up (3 ×)</td><td>not stated</td></tr>");
  check_once(page, "<th scope=\"row\">declared void</th><td>no</td><td>no</td></tr>");
  check_once(page, "<p>One sensor at two times: S-1, run 3 and S-1, run 4.");
  second.evaluation.levels.clear();
  page = render_comparison(first, second).html;
  check_once(page, row("maximum absolute error", {psi(3.3334, 2), "not available"}));
  check_once(page, row("hysteresis, mean over taxels, % FS", {"2.22", "not available"}));
  CHECK(render_comparison(first, second).number.rfind("3-4-", 0) == 0);
  second.run.sensor_serial = first.run.sensor_serial = "";  // not known to be the same
  check_once(render_comparison(first, second).html, "<p>Two sensors: not stated, run 3 and not stated, run 4.");
  check_none(page, "class=\"banner\"");
  second.run.origin = "simulated";
  check_once(render_comparison(first, second).html, "class=\"banner\"");
  check_once(render_comparison(second, first).html, "class=\"banner\"");
}
