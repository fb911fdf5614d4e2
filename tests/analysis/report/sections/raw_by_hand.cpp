// The indication's figures by hand: traces, loops, map of sensitivity, repeatability; and words where there is nothing.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

RawLoop raw_loop_of(const char* name, int taxel, std::vector<double> up, std::vector<double> down) {
  RawLoop loop;
  loop.name = name;
  loop.taxel = taxel;
  loop.full_scale_v = up.back();
  loop.hysteresis_max = 0.2514;
  loop.hysteresis_mean = 0.1014;
  loop.up_v = std::move(up);
  loop.down_v = std::move(down);
  return loop;
}

ReportInput raw_of_two_rows() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.health.rows = 2;
  input.health.columns = 3;
  Behaviour& b = input.behaviour;
  b.taxels = {0, 1, 2};
  b.pressure_psi = {0.0, 20.0, 60.0};
  b.full_scale_v = 2.5;
  b.loops = {raw_loop_of("mean", -1, {0.0, 1.0, 2.5}, {0.0, 1.5, 2.5}),
             raw_loop_of("worst", 5, {0.1, 1.1, 2.6}, {0.1, 1.6, 2.6}),
             raw_loop_of("best", 0, {0.2, 1.2, 2.7}, {0.2, 1.7, 2.7})};
  b.gain = {0.9, 1.0, 1.15, kNone, kNone, kNone};
  b.equilibration_psi = 40.04;
  b.repeats = 4;
  b.repeatability = {{0.0, 1e-3, 2e-3, 3e-3, 4e-3}, {20.0, 5e-3, 1e-3, 2e-3, 8e-3}, {60.0, 2e-3, 6e-3, 7e-3, 1e-3}};
  b.traces = {{"up", {0.0, 60.0}, {0.0, 2.5}}, {"down", {60.0, 0.0}, {2.5, 0.1}}, {"hold", {30.0, 30.5}, {1.2, 1.3}}};
  b.zero_returns = {{"loop", 3, -0.00125, 0.00275, 0.0105, 5}};
  return input;
}

LineChart raw_trace_chart(const RawTrace& trace) {
  return {.title = "Indication of the mean taxel, sequence " + trace.sequence,
          .x_label = "reference value",
          .y_label = "output in V",
          .series = {{"mean taxel", trace.pressure_psi, trace.output_v, 0}},
          .width = 335,
          .height = 255};
}

}  // namespace

TEST_CASE("the indication's loops by hand: out and back along the levels, a style each, named by row and column") {
  const std::string page = raw_section(raw_of_two_rows()).value;
  const std::vector<double> x = {0.0, 20.0, 60.0, 60.0, 20.0, 0.0};
  check_along(page, {.title = "External loop of the indication of the mean, best, median and worst taxel",
                     .x_label = "gauge pressure",
                     .y_label = "output in V",
                     .series = {{"mean taxel", x, {0.0, 1.0, 2.5, 2.5, 1.5, 0.0}, 0},
                                {"worst taxel (1, 2)", x, {0.1, 1.1, 2.6, 2.6, 1.6, 0.1}, 1},
                                {"best taxel (0, 0)", x, {0.2, 1.2, 2.7, 2.7, 1.7, 0.2}, 2}},
                     .width = 682,
                     .height = 330});
  check_once(page, row("mean taxel", {"25.1", "10.1", "2.500"}));
  check_once(page, row("worst taxel (1, 2)", {"25.1", "10.1", "2.600"}));
  check_once(page, row("published sensor, for orientation", {"25.3", "10.0", "–"}));
  check_none(page, "as in Loops and Levels");
  ReportInput input = raw_of_two_rows();
  input.evaluation.levels.resize(1);
  input.evaluation.hysteresis_max_fs = 0.2314;
  input.evaluation.hysteresis_mean_fs = 0.0914;
  input.evaluation.full_scale_v = 3.4564;
  check_once(raw_section(input).value, row("mean taxel, as in Loops and Levels", {"23.1", "9.1", "3.456"}));
  // Of an array whose width is not known each taxel is a row.
  input.health.columns = 0;
  check_once(raw_section(input).value, "<th scope=\"row\">worst taxel (5, 0)</th>");
}

TEST_CASE("the indication's map by hand: sensitivities with two decimals on a scale from the lowest to the highest") {
  ReportInput input = raw_of_two_rows();
  const auto page = [&] { return raw_section(input).value; };
  const char* const title = "Output of each taxel over the mean at one level, pressure increasing";
  check_once(page(), numbered_map({title, 2, 3, {0.9, 1.0, 1.15, kNone, kNone, kNone}, {0.9, 1.15}, 480.0}, 2).value);
  check_once(page(), colour_bar({0.9, 1.15}, "Colour scale of the map of relative sensitivity", "× mean", 2).value);
  check_once(page(), "at " + psi(40.04, 1) + ", increasing.");
  // Two taxels, 0.1 below and above 1, over one degree of freedom.
  input.behaviour.gain = {0.9, 1.1, kNone, kNone, kNone, kNone};
  check_once(page(), "Standard deviation 14.1 %, lowest 0.90, highest 1.10.");
  input.behaviour.gain = {0.9, kNone, 0.9, kNone, kNone, kNone};
  check_once(page(), numbered_map({title, 2, 3, {0.9, kNone, 0.9, kNone, kNone, kNone}, {0.9, 0.901}, 480.0}, 2).value);
  check_once(page(), colour_bar({0.9, 0.901}, "Colour scale of the map of relative sensitivity", "× mean", 2).value);
  input.behaviour.gain.assign(6, kNone);
  check_none(page(), "Map of relative sensitivity");
}

TEST_CASE("the indication's repeatability by hand: four curves in mV over the levels") {
  const std::vector<double> x = {0.0, 20.0, 60.0};
  check_along(raw_section(raw_of_two_rows()).value, {.title = "Repeatability of the output per level",
                                                     .x_label = "gauge pressure",
                                                     .y_label = "s in mV",
                                                     .series = {{"mean taxel, increasing", x, {1.0, 5.0, 2.0}, 0},
                                                                {"mean taxel, decreasing", x, {2.0, 1.0, 6.0}, 1},
                                                                {"taxels (rms), increasing", x, {3.0, 2.0, 7.0}, 2},
                                                                {"taxels (rms), decreasing", x, {4.0, 8.0, 1.0}, 3}},
                                                     .width = 682,
                                                     .height = 245,
                                                     .y_from_zero = true});
}

TEST_CASE("the indication's traces are drawn, two in a row, where there are no models or no full loop was evaluated") {
  ReportInput input = raw_of_two_rows();
  const auto drawn = [&] { return count(raw_section(input).value, "Indication of the mean taxel, sequence "); };
  const std::string page = raw_section(input).value;
  for (const RawTrace& trace : input.behaviour.traces) check_along(page, raw_trace_chart(trace));
  CHECK(count(page, "<div class=\"pair\">\n<figure>") == 2);
  CHECK(drawn() == 3);
  input.evaluation.levels.resize(1);
  CHECK(drawn() == 3);
  input.fit.taxels.push_back(by_hand::left_out(TaxelStatus::kDead));
  CHECK(drawn() == 0);
  input.evaluation.levels.clear();
  CHECK(drawn() == 3);
  input.behaviour.traces.resize(2);
  CHECK(count(raw_section(input).value, "<div class=\"pair\">\n<figure>") == 1);
}

TEST_CASE("the indication without what a part needs: no taxel, an indenter, no loop, no full scale") {
  ReportInput input = raw_of_two_rows();
  check_once(raw_section(input).value, numbers({"3", "−1.25", "−0.050", "2.75", "10.50"}));
  input.behaviour.full_scale_v = 0.0;
  check_once(raw_section(input).value,
             numbers({"3", "−1.25", "not available", "2.75", "10.50"}) + "<td>row 1, column 2</td></tr>");
  check_once(raw_section(input).value, "<h3>Creep</h3>\n<p>not assessed: ");
  check_none(raw_section(input).value, "Loops and hysteresis: not assessed");
  input.behaviour.loops.clear();
  check_once(raw_section(input).value, "Loops and hysteresis: not assessed");
  check_none(raw_section(input).value, "Map of relative sensitivity");
  input.behaviour.taxels.clear();
  const std::string none = raw_section(input).value;
  check_once(none, "<p>not available: no taxel counts</p>");
  check_none(none, "<h3>");
  input.history.presses = true;
  check_once(raw_section(input).value,
             "<p>not available: the run pressed with an indenter; see the object’s figures</p>");
}
