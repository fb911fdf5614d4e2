// The page on a batch by hand: yield, rows of the ranks, outliers, distributions with their limits, loops overlaid.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/overview/overview.h"
#include "analysis/report/overview/overview_figures.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ReportInput batched(std::int64_t run, double error, const char* verdict) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = run;
  input.run.origin = "hardware";
  input.run.sensor_serial = "S-" + std::to_string(run);
  input.run.started_utc = "2024-05-06T07:08:09Z";
  input.evaluation.levels.resize(1);
  input.evaluation.mean_error_psi = error;
  input.evaluation.worst_taxel_mean_error_psi = 2.0 * error;
  input.evaluation.comp_distance_of_mean = 0.01 * error;
  if (*verdict != '\0')
    input.verdicts = {{run, 1, "mean_compensation_error", "array", error, 1.5, "psi", "simple", verdict, "", "", 0}};
  return input;
}

std::vector<ReportInput> batch_of(const std::vector<double>& errors) {
  std::vector<ReportInput> runs;
  for (const double error : errors) runs.push_back(batched(static_cast<std::int64_t>(runs.size()) + 1, error, "pass"));
  return runs;
}

std::string ranked_row(int rank, int run, const std::string& cells) {
  return "<tr><td class=\"n\">" + std::to_string(rank) + "</td><th scope=\"row\">S-" + std::to_string(run) +
         "</th><td class=\"n\">" + std::to_string(run) + "</td><td>2024-05-06</td>" + cells;
}

Histogram distribution(const char* title, const char* label, std::vector<double> values, std::optional<double> limit,
                       int bins) {
  return {.title = title,
          .x_label = label,
          .y_label = "runs",
          .values = std::move(values),
          .limit = limit,
          .limit_name = "tolerance limit",
          .width = 335,
          .height = 180,
          .bins = bins};
}

void check_distribution(const std::string& page, const Histogram& histogram) {
  INFO(histogram.title);
  CHECK(count(page, histogram_chart(histogram).value) == 1);
}

}  // namespace

TEST_CASE("a batch by hand: yield of the sensors with limits, verdicts counted, runs left out") {
  std::vector<ReportInput> runs = {batched(1, 0.1, "pass"), batched(2, 0.2, "conditional pass"),
                                   batched(3, 0.3, "fail"), batched(4, 0.4, "report only"), batched(5, 0.5, "")};
  std::string page = render_batch(runs).html;
  check_once(page, "<th scope=\"row\">sensors, runs named</th><td>5, 5</td>");
  check_once(page, "<td>2 of 3 sensors, 66.7 %</td>");
  check_once(page,
             "<th scope=\"row\">verdicts</th><td>1 conditional pass, 1 fail, 1 no verdict, 1 pass, 1 report "
             "only</td>");
  check_once(page, "stands for it</th><td>none</td>");
  check_once(page, "<p>5 sensors, 5 runs named.");
  runs.push_back(batched(6, 0.1, "pass"));
  runs.back().run.sensor_serial = "S-1";
  runs.back().run.started_utc = "2023-01-01T00:00:00Z";
  page = render_batch(runs).html;
  check_once(page, "<th scope=\"row\">sensors, runs named</th><td>5, 6</td>");
  check_once(page, "stands for it</th><td>S-1, run 6</td>");
  // Without a serial number each run is a sensor of its own.
  runs.resize(2);
  for (ReportInput& run : runs) run.run.sensor_serial.clear();
  CHECK(batch_rows(runs) == std::vector<std::size_t>{0, 1});
  runs[1] = batched(1, 0.2, "pass");
  runs[0] = batched(1, 0.1, "pass");
  CHECK(batch_rows(runs) == std::vector<std::size_t>{0, 1});  // alike: neither gives way
  runs[0].run.void_utc = "2024-06-01T00:00:00Z";
  CHECK(batch_rows(runs) == std::vector<std::size_t>{1});
}

TEST_CASE("a batch by hand: ranks by verdict, then error, without models by hysteresis, outliers are marked") {
  std::vector<ReportInput> runs = batch_of({0.3, 0.2, 0.4, 0.25, 9.0});
  runs[0].verdicts[0].verdict = "fail";
  runs.push_back(batched(6, 0.0, "pass"));
  runs.back().evaluation.levels.clear();
  runs.back().behaviour.loops.emplace_back().hysteresis_mean = 0.2;
  runs.push_back(runs.back());
  runs.back().run.run = 7;
  runs.back().run.sensor_serial = "S-7";
  runs.back().behaviour.loops[0].hysteresis_mean = 0.1;
  const std::string page = render_batch(runs).html;
  const std::string doubt = "<td class=\"n\"><span class=\"doubt\"><span class=\"sign\">▲</span> ";
  check_once(page, ranked_row(1, 2, "<td class=\"n\">0.200 (1.38)</td><td class=\"n\">0.400 (2.76)</td>"));
  check_once(page, ranked_row(2, 4, "<td class=\"n\">0.250 (1.72)</td>"));
  check_once(page, ranked_row(3, 3, "<td class=\"n\">0.400 (2.76)</td>"));
  check_once(page, ranked_row(4, 5,
                              doubt + "9.000 (62.05)</span></td>" + doubt + "18.000 (124.11)</span></td>" + doubt +
                                  "9.00</span></td>"));
  check_once(page, ranked_row(5, 7, "<td class=\"n\">–</td>"));
  check_once(page, ranked_row(6, 6, "<td class=\"n\">–</td>"));
  check_once(page, ranked_row(7, 1, "<td class=\"n\">0.300 (2.07)</td>"));
  check_once(page, "class=\"n\">mean |error|, psi (kPa)</th>");
  check_once(page, "class=\"n\">retries</th>");
  check_once(page,
             "<ul>\n<li>S-5, run 5: corrected: mean absolute error; corrected: mean absolute error of the worst "
             "taxel; corrected: hysteresis of the mean of all pressures, % FS</li>\n</ul>");
  check_once(page, "is beyond ±3.5: far");
}

TEST_CASE("a batch by hand: outliers are looked for among five runs or more, and none may be found") {
  check_once(render_batch(batch_of({0.1, 0.2, 0.3, 0.4})).html, "<p>not assessed: fewer than five runs.</p>");
  const std::string five = render_batch(batch_of({0.1, 0.2, 0.3, 0.4, 0.5})).html;
  check_none(five, "fewer than five runs");
  check_once(five, "<h2 id=\"outliers\">Outliers</h2>\n<p>none</p>");
}

TEST_CASE("a batch by hand: distributions of what the runs have, with their limit where it is one") {
  std::vector<ReportInput> runs = batch_of({0.5, 1.0, 2.0, 0.25, 0.75});
  std::string page = render_batch(runs).html;
  // Twice the root of five runs: four bins.
  check_distribution(page, distribution("corrected: mean absolute error, psi, number of runs", "in psi",
                                        {0.5, 1.0, 2.0, 0.25, 0.75}, 1.5, 4));
  check_distribution(page, distribution("corrected: hysteresis of the mean of all pressures, % FS, number of runs",
                                        "in % FS", {0.5, 1.0, 2.0, 0.25, 0.75}, std::nullopt, 4));
  check_once(page,
             "<figcaption>corrected: mean absolute error, psi; 5 runs: 0.250 to 2.000, median 0.750.</figcaption>");
  check_once(page,
             "<figcaption>corrected: hysteresis of the mean of all pressures, % FS; 5 runs: 0.25 to 2.00, median "
             "0.75.</figcaption>");
  const auto part = [](const std::string& whole) {
    const std::size_t from = whole.find("<div class=\"keep\"><h2 id=\"histograms\"");
    return whole.substr(from, whole.find("<h2 id=\"loops\"") - from);
  };
  // Three figures: a pair, and one alone; the heading stays with the pair.
  CHECK(count(part(page), "<figure>") == 3);
  CHECK(count(part(page), "<div class=\"pair\">") == 2);
  CHECK(count(part(page), "</figure>\n</div>\n</div>\n<div class=\"pair\">\n") == 1);
  CHECK(count(part(page), "<div") == count(part(page), "</div>"));
  runs[2].verdicts[0].limit = 2.5;
  page = render_batch(runs).html;
  check_distribution(page, distribution("corrected: mean absolute error, psi, number of runs", "in psi",
                                        {0.5, 1.0, 2.0, 0.25, 0.75}, std::nullopt, 4));
  check_once(page, "The runs were judged by several tolerance limits: none is drawn.");
  // In kPa, and of ten runs six bins: twice 3.16.
  const std::vector<ReportInput> once = runs;
  runs.insert(runs.end(), once.begin(), once.end());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].unit = PressureUnit::kKilopascal;
    runs[i].run.sensor_serial.clear();
    runs[i].verdicts[0].limit = 1.5;
  }
  std::vector<double> kpa;
  for (const double error : {0.5, 1.0, 2.0, 0.25, 0.75, 0.5, 1.0, 2.0, 0.25, 0.75})
    kpa.push_back(PressureUnit(PressureUnit::kKilopascal).of(error));
  page = render_batch(runs).html;
  check_distribution(page, distribution("corrected: mean absolute error, kPa, number of runs", "in kPa", kpa,
                                        PressureUnit(PressureUnit::kKilopascal).of(1.5), 6));
  check_once(page, "kPa; 10 runs: 1.72 to 13.79, median 5.17.</figcaption>");
  // A figure alone, and none.
  runs.resize(2);
  for (ReportInput& run : runs) {
    run.evaluation.levels.clear();
    run.health.high_v = {1.0};
  }
  page = part(render_batch(runs).html);
  CHECK(count(page, "<figure>") == 1);
  CHECK(count(page, "<div") == count(page, "</div>"));
  check_once(page, "<figcaption>excluded taxels; 2 runs: 0 to 0, median 0.</figcaption>");
  for (ReportInput& run : runs) run.health.high_v.clear();
  CHECK(part(render_batch(runs).html) ==
        "<div class=\"keep\"><h2 id=\"histograms\">Distributions and limits</h2>\n<p>not available</p>\n</div>\n");
}

TEST_CASE("mean loops overlaid by hand: named with a style each up to five runs, else alike and without names") {
  std::vector<ReportInput> runs;
  for (int i = 1; i <= 5; ++i) {
    runs.push_back(batched(i, 0.1, ""));
    runs.back().behaviour.pressure_psi = {0.0, 60.0};
    runs.back().behaviour.loops.emplace_back();
    runs.back().behaviour.loops[0].up_v = {0.0, 1.0 * i};
    runs.back().behaviour.loops[0].down_v = {0.1, 1.1 * i};
  }
  runs[1].behaviour.loops.clear();
  const auto chart = [&](bool named) {
    LineChart out{.title = "Mean external loops of the indication of all runs",
                  .x_label = "gauge pressure",
                  .y_label = "output in V",
                  .series = {},
                  .width = 682,
                  .height = 285};
    int style = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const double n = static_cast<double>(i) + 1.0;
      if (i != 1)
        out.series.push_back({named ? "S-" + std::to_string(i + 1) + ", run " + std::to_string(i + 1) : std::string(),
                              {0.0, 60.0, 60.0, 0.0},
                              {0.0, 1.0 * n, 1.1 * n, 0.1},
                              named ? style++ : 0});
    }
    return out;
  };
  check_along(loops_overlaid(runs).value, chart(true));
  check_once(loops_overlaid(runs).value, "External loops of the mean taxels, 4 runs.");
  runs.push_back(runs.back());
  runs.back().behaviour.loops[0].up_v = {0.0, 6.0};
  runs.back().behaviour.loops[0].down_v = {0.1, 1.1 * 6};
  check_along(loops_overlaid(runs).value, chart(false));
  runs.resize(2);
  check_once(loops_overlaid(runs).value, "External loops of the mean taxels, 1 run.");
  runs.erase(runs.begin());
  check_once(loops_overlaid(runs).value, "<p>not available</p>");
}
