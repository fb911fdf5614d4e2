// Levels and loops of the mean taxel by hand: rows, what is worse, charts, errors of each sequence.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

LevelFigures printed_level(double pressure, double step) {
  LevelFigures level;
  level.pressure_psi = pressure;
  level.up_psi = pressure + 0.014;
  level.down_psi = pressure - 0.024;
  level.raw_std_up = 0.11114 + step;
  level.raw_std_down = 0.12224 + step;
  level.raw_distance = 0.13334 + step;
  level.comp_std_up = 0.01114 + step;
  level.comp_std_down = 0.01224 + step;
  level.comp_distance = 0.01334 + step;
  level.comp_distance_observable = 0.01444 + step;
  level.worst_taxel_distance = 0.01554 + step;
  level.flat_taxels = 1;
  return level;
}

// Two taxels with a model; the second level is flat for both.
ReportInput two_levels() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.evaluation.full_scale_v = 3.4564;
  input.evaluation.full_scale_psi = 60.04;
  input.evaluation.levels = {printed_level(20.0, 0.0), printed_level(50.0, 0.05)};
  input.evaluation.levels[1].flat_taxels = 2;
  input.fit.taxels.resize(3);  // two of the array and the mean taxel
  for (ModelTaxel& taxel : input.fit.taxels) taxel.status = TaxelStatus::kFitted;
  input.fit.taxels.back().taxel = kMeanTaxel;
  return input;
}

Trace printed_trace() { return {"descending", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.0}, {0.1, 0.9, 2.0}, {1.0, 28.0, 60.0}}; }

}  // namespace

TEST_CASE("levels by hand: each figure of a row, and none without flat taxels where all are flat") {
  const std::string page = levels_section(two_levels()).value;
  check_once(page,
             level_head("20.0", "137.9") +
                 numbers({"20.01", "19.98", "11.11", "12.22", "13.33", "1.11", "1.22", "1.33", "1.44", "1.55", "1"}) +
                 "<td>smaller</td></tr>");
  check_once(page, level_head("50.0", "344.7") +
                       numbers({"50.01", "49.98", "16.11", "17.22", "18.33", "6.11", "6.22", "6.33", "not available",
                                "6.55", "2"}) +
                       "<td>smaller</td></tr>");
  check_once(page, "<li>hysteresis: larger at none of 2 levels.</li>");
  check_once(page, "<li>non-uniformity (s), increasing or decreasing: larger at none of 2 levels.</li>");
  check_once(page, "FS of the indication: 3.456 V, the highest");
  check_once(page, "of the corrected indication: " + psi(60.04, 1) + ".</p>");
  check_once(page, "reference value, psi</th>");
  ReportInput none = two_levels();
  none.evaluation.levels.clear();
  check_once(levels_section(none).value, "<p>not available</p>");
}

TEST_CASE("levels by hand: what is worse is named at the level and counted with its pressures") {
  ReportInput input = two_levels();
  std::vector<LevelFigures>& levels = input.evaluation.levels;
  levels.push_back(printed_level(59.6, 0.0));
  levels[0].comp_std_up = 0.2;
  levels[1].comp_std_down = 0.2;
  levels[2].comp_std_up = levels[2].comp_std_down = 0.2;
  levels[2].made_worse = true;
  const std::string page = levels_section(input).value;
  const std::string worse = "<td><span class=\"worse\"><span class=\"sign\">▲</span> worse: ";
  check_once(page, worse + "s incr.</span></td></tr>");
  check_once(page, worse + "s decr.</span></td></tr>");
  check_once(page, worse + "hysteresis, s incr., s decr.</span></td></tr>");
  check_once(page,
             "<li>hysteresis: <span class=\"worse\"><span class=\"sign\">▲</span> larger at 1 of 3 levels</span> "
             "(60 psi).</li>");
  check_once(page, "larger at 3 of 3 levels</span> (20, 50, 60 psi).</li>");
}

TEST_CASE("levels by hand: the two charts in per cent of full scale") {
  const std::string page = levels_section(two_levels()).value;
  const std::vector<double> x = {20.0, 50.0};
  const auto in_percent = [](double share) { return std::vector<double>{100.0 * share, 100.0 * (share + 0.05)}; };
  LineChart chart{.title = "Hysteresis of indication and corrected indication per level",
                  .x_label = "gauge pressure",
                  .y_label = "hysteresis in % FS",
                  .series = {{"indication", x, in_percent(0.13334), 1},
                             {"corrected", x, in_percent(0.01334), 2},
                             {"corrected, without flat", x, {1.444, kNone}, 3}},
                  .width = 335,
                  .height = 285,
                  .y_from_zero = true};
  check_along(page, chart);
  chart.title = "Standard deviation over the taxels per level, indication and corrected indication";
  chart.y_label = "s in % FS";
  chart.series = {{"increasing, indication", x, in_percent(0.11114), 1},
                  {"decreasing, indication", x, in_percent(0.12224), 4},
                  {"increasing, corrected", x, in_percent(0.01114), 2},
                  {"decreasing, corrected", x, in_percent(0.01224), 3}};
  check_along(page, chart);
}

TEST_CASE("loops by hand: measured and modelled, corrected against an ideal line, residuals in mV, errors in shares") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.model = "elam";
  input.evaluation.full_scale_v = 2.5;
  input.evaluation.traces = {printed_trace()};
  const std::string page = loops_section(input).value, of = "mean taxel, sequence descending";
  const std::vector<double> x = {0.0, 30.0, 60.0};
  check_along(page, {.title = "Output voltage measured and by the ELAM model against pressure, " + of,
                     .x_label = "reference value",
                     .y_label = "output in V",
                     .series = {{"measured", x, {0.0, 1.0, 2.0}, 0}, {"ELAM model", x, {0.1, 0.9, 2.0}, 1}},
                     .width = 335,
                     .height = 265});
  LineChart corrected{.title = "Corrected indication against reference value, " + of,
                      .x_label = "reference value",
                      .y_label = "corrected indication",
                      .series = {{"corrected", x, {1.0, 28.0, 60.0}, 2, true}, {"ideal", {0.0, 60.0}, {0.0, 60.0}, 0}},
                      .width = 335,
                      .height = 265};
  check_both(page, corrected);
  LineChart residuals{
      .title = "Lack of fit of the ELAM model against pressure, " + of,
      .x_label = "reference value",
      .y_label = "residual in mV",
      .series = {{"model minus measured", x, {1000.0 * (0.1 - 0.0), 1000.0 * (0.9 - 1.0), 0.0}, 1, true}},
      .width = 682,
      .height = 180};
  check_along(page, residuals);
  // 0.1, 0.1 and 0 V of 2.5 V; 1, 2 and 0 psi.
  check_once(page, row("descending", {"3", "0.0667", "2.67", "0.1000", "4.00", psi(1.0, 2), psi(2.0, 2)}));
  check_once(page, "highest mean output of the array, 2.500 V.</p>");
  // Of one step there is no ideal line; residuals end with the shortest list.
  input.evaluation.traces[0].pressure_psi = {30.0, kNone, kNone};
  input.evaluation.traces[0].model_v.resize(2);
  corrected.series = {{"corrected", {30.0, kNone, kNone}, {1.0, 28.0, 60.0}, 2, true}};
  check_both(loops_section(input).value, corrected);
  residuals.series[0].x = {30.0, kNone};
  residuals.series[0].y.resize(2);
  check_along(loops_section(input).value, residuals);
  input.evaluation.traces[0] = printed_trace();
  input.evaluation.traces[0].measured_v.resize(1);
  residuals.series[0].x = {0.0};
  residuals.series[0].y.resize(1);
  check_along(loops_section(input).value, residuals);
  input.evaluation.traces[0] = printed_trace();
  input.evaluation.traces[0].pressure_psi.resize(1);
  check_along(loops_section(input).value, residuals);
  input.evaluation.traces.clear();
  check_once(loops_section(input).value, "<p>not available</p>");
}
