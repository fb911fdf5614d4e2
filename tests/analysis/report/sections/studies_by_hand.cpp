// Studies by hand: crosstalk, rate and hold, mounts and uniformity, each number of a table and each chart's data.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ReportInput studied() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = 1;
  input.fit.columns = 2;
  return input;
}

Crosstalk pressed_points() {
  Crosstalk c;
  c.not_assessed.clear();
  c.run = 17;
  c.positions = 1;
  c.force_n = 5.126;
  c.reach_pitches = 2.0;
  c.row = {0.012344, 0.002344, 0.032344, 61};
  c.column = {0.022344, 0.003344, 0.042344, 62};
  c.elsewhere = {0.000344, 0.000144, 0.001344, 63};
  c.distance_pitches = {0.0, 1.0, 1.999, 2.0, 3.0};
  c.along_row_share = {1.0, 0.5, 0.4, 0.03, 0.02};
  c.along_column_share = {1.0, 0.6, 0.5, 0.05, 0.04};
  return c;
}

ErrorSum errors_of_bin(double sum, double max, int samples) {
  ErrorSum error;
  error.sum = sum;
  error.max = max;
  error.samples = samples;
  return error;
}

RateHoldRun paced_run(std::int64_t run, const char* sequence, std::vector<Bin> by_hold, std::vector<Bin> by_rate) {
  return {run, sequence, errors_of_bin(5.0, 1.234, 8), std::move(by_hold), std::move(by_rate), 0.0, 0.0};
}

LineChart pace_chart(const char* over, const char* x_label, std::vector<Series> series) {
  return {.title = std::string("Mean absolute error of the corrected indication over the ") + over,
          .x_label = x_label,
          .y_label = "mean |error|",
          .series = std::move(series),
          .width = 335,
          .height = 245,
          .y_from_zero = true};
}

void check_up(const std::string& page, const LineChart& chart) {
  INFO(chart.title);
  CHECK(count(page, line_chart(pressure_up(chart, PressureUnit::kPsi)).value) == 1);
}

}  // namespace

TEST_CASE("crosstalk by hand: zones in per cent, ghosts, and outputs from two pitches on in the chart") {
  ReportInput input = studied();
  input.more.studies.crosstalk = pressed_points();
  std::string page = studies_section(input).value;
  check_once(page, "<p>Run 17: a point indenter at 1 position, 5.13 N. Output");
  check_once(page, "(more than 2 pitches from the print’s centre");
  check_once(page, row("in a loaded row", {"1.234", "0.234", "3.234", "61"}));
  check_once(page, row("in a loaded column", {"2.234", "0.334", "4.234", "62"}));
  check_once(page, row("elsewhere", {"0.034", "0.014", "0.134", "63"}));
  check_once(page, "<li>No ghost rows were found.</li>");
  check_once(page, "<li>No ghost columns were found.</li>");
  check_once(page, "more than elsewhere by 0.5 % and by");
  check_once(page, line_chart({.title = "Output of unloaded taxels along the loaded rows and columns over distance",
                               .x_label = "distance in pitches",
                               .y_label = "output, % of highest",
                               .series = {{"along the rows", {2.0, 3.0}, {3.0, 2.0}, 1},
                                          {"along the columns", {2.0, 3.0}, {5.0, 4.0}, 2}},
                               .width = 682,
                               .height = 200,
                               .y_from_zero = true})
                       .value);
  input.more.studies.crosstalk.ghost_rows = {{3, 0.01234}, {5, 0.02234}};
  input.more.studies.crosstalk.ghost_columns = {{7, 0.03234}};
  page = studies_section(input).value;
  check_once(page, "Ghost rows</span>: 3 (1.23 %), 5 (2.23 %).</li>");
  check_once(page, "Ghost columns</span>: 7 (3.23 %).</li>");
  input.more.studies.crosstalk.not_assessed = "no point was pressed";
  page = studies_section(input).value;
  check_once(page, "<h3>Crosstalk</h3>\n<p>not assessed: no point was pressed.</p>");
  check_none(page, "in a loaded row");
}

TEST_CASE("rate and hold by hand: rows of bins, errors of a run, charts of runs with two bins or more") {
  ReportInput input = studied();
  RateHold& study = input.more.studies.rate_hold;
  study.not_assessed.clear();
  // Of a bin from 1 to 100 the middle is 10: its logarithm is 1; from 10 to 1000 it is 2.
  const std::vector<Bin> two = {{1.0, 100.0, errors_of_bin(1.0, 0.876, 4)},
                                {10.0, 1000.0, errors_of_bin(1.5, 0.987, 2)}};
  const std::vector<Bin> one = {{0.1234, 0.5678, errors_of_bin(0.8, 0.456, 2)}};
  study.runs = {paced_run(21, "creep-hold", two, one), paced_run(22, "rate", {}, two)};
  study.runs[1].output_max_share = 0.01234;
  study.runs[1].output_mean_share = 0.00234;
  std::string page = studies_section(input).value;
  check_once(page, "<h4>Sequence creep-hold, run 21</h4>");
  CHECK(count(page,
              "<p>Mean absolute error " + psi(0.625, 3) + ", maximum " + psi(1.234, 2) + ", over 8 samples.</p>") == 2);
  check_once(page, "by up to 1.23 % FS, 0.23 % FS on average.</p>");
  // Two bins by hold and by rate, one by rate.
  CHECK(count(page, row("1 to 100", {"4", psi(0.25, 3), psi(0.876, 2)})) == 2);
  CHECK(count(page, row("10 to 1 × 10^3", {"2", psi(0.75, 3), psi(0.987, 2)})) == 2);
  check_once(page, row("0.123 to 0.568", {"2", psi(0.4, 3), psi(0.456, 2)}));
  CHECK(count(page, "<caption>Error by hold</caption>") == 1);
  CHECK(count(page, "<caption>Error by rate</caption>") == 2);
  check_once(page, "<th scope=\"col\">held, s</th>");
  CHECK(count(page, "<th scope=\"col\">rate, psi/s</th>") == 2);
  check_up(page, pace_chart("time that a level was held", "log10 of the hold in s",
                            {{"creep-hold, run 21", {1.0, 2.0}, {0.25, 0.75}, 1}}));
  check_up(page, pace_chart("rate of the pressure", "log10 of the rate in psi/s",
                            {{"rate, run 22", {1.0, 2.0}, {0.25, 0.75}, 2}}));
  check_once(page, "<figcaption>Error against hold.</figcaption>");
  check_once(page, "<figcaption>Error against rate.</figcaption>");
  // In kPa the rates are 6.8948 times as many, those of the axis and of the table.
  input.unit = PressureUnit::kKilopascal;
  const std::string kpa = studies_section(input).value;
  check_once(kpa, "<th scope=\"row\">0.851 to 3.91</th>");
  check_once(kpa, "<th scope=\"row\">6.89 to 689</th>");
  check_once(kpa, "<th scope=\"row\">1 to 100</th>");
  CHECK(
      count(kpa, line_chart(pressure_up(
                                pace_chart("rate of the pressure", "log10 of the rate in kPa/s",
                                           {{"rate, run 22",
                                             {1.0 + std::log10(6.894757293168361), 2.0 + std::log10(6.894757293168361)},
                                             {0.25, 0.75},
                                             2}}),
                                PressureUnit::kKilopascal))
                     .value) == 1);
  input.unit = PressureUnit::kPsi;
  study.runs[1].by_rate.resize(1);
  page = studies_section(input).value;
  check_none(page, "Error against rate.");
  check_once(page, "Error against hold.");
  study.runs[0].by_hold.clear();
  page = studies_section(input).value;
  check_none(page, "Error against hold.");
  CHECK(count(page, "<caption>Error by rate</caption>") == 2);
  check_none(page, "<div class=\"pair\">");
}

TEST_CASE("mounts by hand: their chart, the map of each taxel with its scale, a row of every level") {
  Remount remount;
  remount.not_assessed.clear();
  remount.runs = {12};
  remount.pressure_psi = {20.0, 40.0};
  remount.within_psi = {0.12341, 0.2};
  remount.between_psi = {0.23451, 0.3};
  remount.mean_between_psi = {0.04561, 0.1};
  remount.taxel_between_psi = {0.25, 0.5, kNone};
  const auto page = [&] { return remount_part(remount, 1, 3, PressureUnit::kPsi).value; };
  check_once(page(), "<p>1 mounts of the sensor, runs 12, all");
  check_once(page(),
             level_head("20.0", "137.9") + numbers({psi(0.12341, 3), psi(0.23451, 3), psi(0.04561, 3)}) + "</tr>");
  check_once(page(), level_head("40.0", "275.8") + numbers({psi(0.2, 3), psi(0.3, 3), psi(0.1, 3)}) + "</tr>");
  check_both(page(), {.title = "Standard deviation within and between mounts per level",
                      .x_label = "gauge pressure",
                      .y_label = "standard deviation",
                      .series = {{"within a mount", {20.0, 40.0}, {0.12341, 0.2}, 2},
                                 {"between mounts", {20.0, 40.0}, {0.23451, 0.3}, 1},
                                 {"between, array mean", {20.0, 40.0}, {0.04561, 0.1}, 3}},
                      .width = 335,
                      .height = 255,
                      .y_from_zero = true});
  const char* const title = "Standard deviation between mounts of each taxel";
  check_once(page(), frame_map({title, 1, 3, {0.25, 0.5, kNone}, {0.0, 0.5}, 190.0}).value);
  check_once(page(), pressure_bar({0.0, 0.5}, "Colour scale of the map of mounts", PressureUnit::kPsi, 2).value);
  for (const std::vector<double>& nothing : {std::vector<double>{0.0, 0.0, 0.0}, {kNone, kNone, kNone}}) {
    remount.taxel_between_psi = nothing;
    check_once(page(), frame_map({title, 1, 3, nothing, {0.0, 1.0}, 190.0}).value);
  }
  remount.not_assessed = "one mount alone";
  CHECK(page() == "<h3>Reproducibility: mounting</h3>\n<p>not assessed: one mount alone.</p>\n");
}

TEST_CASE(
    "uniformity by hand: figures, the other sense of the angles, both maps in per cent, their scales, the chart") {
  Uniformity u;
  u.not_assessed.clear();
  u.runs = {12, 15};
  u.angles_deg = {0, 90};
  u.pressure_psi = {20.0, 40.0};
  u.u_psi = {0.1, 0.2};
  u.residual_psi = {0.01, 0.02};
  u.chamber_share = {-0.0125, 0.005, kNone};
  u.sensor_share = {0.02, -0.01, 0.0};
  u.u_share = 0.012341;
  u.u_offset_psi = 0.12341;
  u.residual_rms_psi = 0.05;
  u.residual_other_sense_psi = 0.046;
  u.undetermined = 3;
  const auto page = [&] { return uniformity_part(u, 1, 3, PressureUnit::kPsi).value; };
  check_once(page(), "<p>Runs 12, 15 of the sensor turned in the chamber by 0°, 90° (counter-clockwise");
  check_once(page(), "<td>1.23 % of the pressure</td>");
  check_once(page(), "standard uncertainty</th><td>" + psi(0.12341, 3) + "</td>");
  check_once(page(), "over all levels</th><td>" + psi(0.05, 3) + "</td>");
  check_once(page(), "in the other sense</th><td>" + psi(0.046, 3) + "</td>");  // 0.92 of it
  check_once(page(), "<td>3 sets of places");
  u.residual_other_sense_psi = 0.044;  // 0.88
  check_once(page(), psi(0.044, 3) + " <span class=\"doubt\">");
  const char *const chamber = "The chamber’s part, % of the pressure",
                    *const sensor = "The sensor’s part (error of its models), % of the pressure";
  check_once(page(), frame_map({chamber, 1, 3, {-1.25, 0.5, kNone}, {-1.25, 1.25}, 190.0}).value);
  check_once(page(), frame_map({sensor, 1, 3, {2.0, -1.0, 0.0}, {-2.0, 2.0}, 190.0}).value);
  check_once(page(), colour_bar({-1.25, 1.25}, "Colour scale of the chamber’s part", "%", 2).value);
  check_once(page(), colour_bar({-2.0, 2.0}, "Colour scale of the sensor’s part", "%", 2).value);
  check_both(page(), {.title = "Standard deviation of the chamber’s part and of the residual per level",
                      .x_label = "gauge pressure",
                      .y_label = "standard deviation",
                      .series = {{"chamber", {20.0, 40.0}, {0.1, 0.2}, 1}, {"residual", {20.0, 40.0}, {0.01, 0.02}, 2}},
                      .width = 682,
                      .height = 225,
                      .y_from_zero = true});
  u.sensor_share = {0.0025, -0.001, kNone};
  check_once(page(), colour_bar({-0.25, 0.25}, "Colour scale of the sensor’s part", "%", 2).value);
  u.sensor_share = {0.0, 0.0, kNone};
  check_once(page(), colour_bar({0.0, 1.0}, "Colour scale of the sensor’s part", "%", 2).value);
  u.not_assessed = "one angle alone";
  CHECK(page() == "<h3>Uniformity of the chamber</h3>\n<p>not assessed: one angle alone.</p>\n");
}

TEST_CASE("the studies' maps have the shape of the array of models") {
  ReportInput input = studied();
  input.more.studies.remount.not_assessed.clear();
  input.more.studies.remount.taxel_between_psi = {0.25, 0.5};
  input.more.studies.uniformity.not_assessed.clear();
  input.more.studies.uniformity.chamber_share = input.more.studies.uniformity.sensor_share = {0.01, -0.01};
  CHECK(count(studies_section(input).value, "class=\"map\" viewBox=\"0 0 190 95\"") == 3);
}
