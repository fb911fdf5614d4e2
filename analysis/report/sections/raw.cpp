#include <algorithm>
#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

std::string loop_name(const RawLoop& loop, int columns) {
  if (loop.taxel < 0) return loop.name + " taxel";
  return fmt::format("{} taxel ({}, {})", loop.name, loop.taxel / std::max(1, columns),
                     loop.taxel % std::max(1, columns));
}

Markup trace_figures_raw(const Behaviour& b, PressureUnit unit) {
  Markup out;
  for (std::size_t i = 0; i < b.traces.size(); i += 2) {
    out += markup("<div class=\"pair\">\n");
    for (std::size_t j = i; j < std::min(i + 2, b.traces.size()); ++j) {
      const RawTrace& trace = b.traces[j];
      out += markup(
          "<figure>{}<figcaption>Sequence {}: output of the mean taxel, mean of the repeats.</figcaption></figure>\n",
          line_chart(pressure_along({.title = "Indication of the mean taxel, sequence " + trace.sequence,
                                     .x_label = "reference value",
                                     .y_label = "output in V",
                                     .series = {{"mean taxel", trace.pressure_psi, trace.output_v, 0, false}},
                                     .width = 335,
                                     .height = 255},
                                    unit)),
          html::stated(trace.sequence));
    }
    out += markup("</div>\n");
  }
  return out;
}

Markup loops_figure(const Behaviour& b, int columns, PressureUnit unit) {
  LineChart chart{.title = "External loop of the indication of the mean, best, median and worst taxel",
                  .x_label = "gauge pressure",
                  .y_label = "output in V",
                  .series = {},
                  .width = 682,
                  .height = 330};
  int style = 0;
  for (const RawLoop& loop : b.loops) {
    std::vector<double> pressure = b.pressure_psi, output = loop.up_v;
    pressure.insert(pressure.end(), b.pressure_psi.rbegin(), b.pressure_psi.rend());
    output.insert(output.end(), loop.down_v.rbegin(), loop.down_v.rend());
    chart.series.push_back({loop_name(loop, columns), pressure, output, style++, false});
  }
  return markup(
      "<figure>{}<figcaption>External loops, increasing pressure below and decreasing above, on set-points. Best, "
      "median "
      "and worst by the mean hysteresis.</figcaption></figure>\n",
      line_chart(pressure_along(std::move(chart), unit)));
}

Markup hysteresis_table(const Behaviour& b, const Evaluation& evaluation, int columns) {
  Markup out = markup(
      "<table><caption>Hysteresis of the indication</caption><thead><tr><th scope=\"col\">taxel</th>"
      "<th scope=\"col\" class=\"n\">maximum, % FS</th><th scope=\"col\" class=\"n\">mean, % FS</th>"
      "<th scope=\"col\" class=\"n\">FS, V</th></tr></thead><tbody>\n");
  const auto row = [&](const html::Safe& name, const html::Safe& most, const html::Safe& mean, const html::Safe& fs) {
    out += markup("<tr><th scope=\"row\">{}</th>{}{}{}</tr>\n", name, number_cell(most), number_cell(mean),
                  number_cell(fs));
  };
  for (const RawLoop& loop : b.loops)
    row(Text(loop_name(loop, columns)), html::percent(loop.hysteresis_max, 1), html::percent(loop.hysteresis_mean, 1),
        html::fixed(loop.full_scale_v, 3));
  if (!evaluation.levels.empty())
    row(Text("mean taxel, as in Loops and Levels"), html::percent(evaluation.hysteresis_max_fs, 1),
        html::percent(evaluation.hysteresis_mean_fs, 1), html::fixed(evaluation.full_scale_v, 3));
  row(Text("published sensor, for orientation"), Text("25.3"), Text("10.0"), Text("–"));
  out += markup(
      "</tbody></table>\n<p class=\"note\">Hysteresis: difference of the outputs at one level between increasing and "
      "decreasing pressure, maximum and mean over the levels of the external loop. FS: the highest of the "
      "loop’s outputs at its levels, each the mean of the sweeps. Published "
      "sensor: Sánchez-Durán et al., Sensors 2015; it is not a limit.</p>\n");
  return out;
}

Markup gain_figures(const Behaviour& b, int rows, int columns, PressureUnit unit) {
  const Spread spread = spread_of(b.gain);
  if (spread.count == 0) return {};
  const double squares = squares_about(finite_of(b.gain), 1.0);
  const double deviation_of_gain = spread.count > 1 ? std::sqrt(squares / static_cast<double>(spread.count - 1)) : kNan;
  const ColourScale scale{spread.low, spread.high > spread.low ? spread.high : spread.low + 1e-3};
  Markup out = markup("<div class=\"keep\"><h3>Map of relative sensitivity</h3>\n<figure>{}",
                      numbered_map({"Output of each taxel over the mean at one level, pressure increasing", rows,
                                    columns, b.gain, scale, 480.0},
                                   2));
  out += colour_bar(scale, "Colour scale of the map of relative sensitivity", "× mean", 2);
  out += markup(
      "<figcaption>Output of each taxel over the mean of all that count, at {}, increasing. Standard deviation {} %, "
      "lowest {}, highest {}. A cross: not counted. A non-uniform pressure in the chamber would look the "
      "same.</figcaption></figure></div>\n",
      html::pressure(b.equilibration_psi, unit, 1), html::percent(deviation_of_gain, 1), html::fixed(spread.low, 2),
      html::fixed(spread.high, 2));
  return out;
}

Markup repeatability_part(const Behaviour& b, PressureUnit unit) {
  Markup out = markup("<h3>Repeatability</h3>\n");
  if (b.repeatability.empty()) {
    out += markup("<p>not assessed: fewer than two complete repeats of the external loop.</p>\n");
    return out;
  }
  const auto column = [&](double LevelRepeatability::*figure) {
    std::vector<double> out_of;
    for (const LevelRepeatability& level : b.repeatability) out_of.push_back(1e3 * level.*figure);
    return out_of;
  };
  std::vector<double> pressure;
  for (const LevelRepeatability& level : b.repeatability) pressure.push_back(level.pressure_psi);
  out += markup(
      "<figure>{}<figcaption>Standard deviation over {} repeats of the output at one level.</figcaption></figure>\n",
      line_chart(pressure_along(
          {.title = "Repeatability of the output per level",
           .x_label = "gauge pressure",
           .y_label = "s in mV",
           .series = {{"mean taxel, increasing", pressure, column(&LevelRepeatability::mean_up_v), 0, false},
                      {"mean taxel, decreasing", pressure, column(&LevelRepeatability::mean_down_v), 1, false},
                      {"taxels (rms), increasing", pressure, column(&LevelRepeatability::taxel_up_v), 2, false},
                      {"taxels (rms), decreasing", pressure, column(&LevelRepeatability::taxel_down_v), 3, false}},
           .width = 682,
           .height = 245,
           .y_from_zero = true},
          unit)),
      b.repeats);
  const auto worst = [&](double LevelRepeatability::*figure) {
    return *std::ranges::max_element(b.repeatability, {}, figure);
  };
  out += markup(
      "<table><caption>Repeatability: largest standard deviation over the levels</caption><thead><tr>"
      "<th scope=\"col\">of</th><th scope=\"col\" class=\"n\">mV</th><th scope=\"col\" class=\"n\">% FS</th>"
      "<th scope=\"col\" class=\"n\">at</th></tr></thead><tbody>\n");
  for (const auto& [name, figure] : {std::pair{"mean taxel, increasing", &LevelRepeatability::mean_up_v},
                                     {"mean taxel, decreasing", &LevelRepeatability::mean_down_v},
                                     {"a taxel (rms over taxels), increasing", &LevelRepeatability::taxel_up_v},
                                     {"a taxel (rms over taxels), decreasing", &LevelRepeatability::taxel_down_v}}) {
    const LevelRepeatability& level = worst(figure);
    out += markup("<tr><th scope=\"row\">{}</th>{}{}{}</tr>\n", Text(name),
                  number_cell(html::fixed(1e3 * level.*figure, 2)),
                  number_cell(html::percent(level.*figure / b.full_scale_v, 3)),
                  number_cell(html::pressure(level.pressure_psi, unit, 0)));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup zero_part(const Behaviour& b, int columns) {
  Markup out = markup("<h3>Zero deviation</h3>\n");
  if (b.zero_returns.empty()) {
    out += markup("<p>not assessed: no sequence comes back to where it began.</p>\n");
    return out;
  }
  out += markup(
      "<table><caption>Zero deviation: output at the lowest pressure, end of a repeat less its "
      "start</caption><thead><tr>"
      "<th scope=\"col\">sequence</th><th scope=\"col\" class=\"n\">repeats</th><th scope=\"col\" class=\"n\">mean "
      "taxel, "
      "mV</th><th scope=\"col\" class=\"n\">% FS</th><th scope=\"col\" class=\"n\">largest of one repeat, mV</th>"
      "<th scope=\"col\" class=\"n\">worst taxel, mV</th><th scope=\"col\">which</th></tr></thead><tbody>\n");
  for (const ZeroReturn& zero : b.zero_returns) {
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td>{}{}{}{}<td>{}</td></tr>\n",
                  html::stated(zero.sequence), zero.repeats, number_cell(html::fixed(1e3 * zero.mean_v, 2)),
                  number_cell(html::percent(b.full_scale_v > 0.0 ? zero.mean_v / b.full_scale_v : kNan, 3)),
                  number_cell(html::fixed(1e3 * zero.largest_v, 2)),
                  number_cell(html::fixed(1e3 * zero.worst_taxel_v, 2)), Text(place_of(zero.worst_taxel, columns)));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup creep_part(const Behaviour& b, PressureUnit unit) {
  Markup out = markup("<h3>Creep</h3>\n");
  if (b.creep.empty()) {
    out += markup(
        "<p>not assessed: no run with a held level was given (recipes creep-hold, creep-levels; name the run after "
        "this one).</p>\n");
    return out;
  }
  out += markup(
      "<table><caption>Creep of the mean taxel at held levels</caption><thead><tr><th scope=\"col\">sequence</th>"
      "<th scope=\"col\" class=\"n\">level</th><th scope=\"col\">branch</th><th scope=\"col\" class=\"n\">from, "
      "s</th><th scope=\"col\" "
      "class=\"n\">to, s</th><th scope=\"col\" class=\"n\">first, V</th><th scope=\"col\" class=\"n\">last, V</th>"
      "<th scope=\"col\" class=\"n\">% of output a decade of time</th></tr></thead><tbody>\n");
  for (const Creep& creep : b.creep) {
    out += markup("<tr><th scope=\"row\">{}</th>{}{}{}{}{}{}<td class=\"n\">{} ± {}</td></tr>\n",
                  html::stated(creep.sequence), number_cell(html::pressure(creep.pressure_psi, unit, 1)),
                  markup("<td class=\"state\">{}</td>", Text(branch_in_words(creep.up))),
                  number_cell(html::fixed(creep.from_s, 1)), number_cell(html::fixed(creep.to_s, 1)),
                  number_cell(html::fixed(creep.first_v, 4)), number_cell(html::fixed(creep.last_v, 4)),
                  html::percent(creep.per_decade, 3), html::percent(creep.per_decade_u, 3));
  }
  out += markup(
      "</tbody></table>\n<p class=\"note\">Line through the output over the logarithm of the time since the level was "
      "commanded; ± one standard uncertainty of the slope, residuals taken as independent.</p>\n");
  return out;
}

}  // namespace

Markup raw_section(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  const int rows = input.health.rows, columns = input.health.columns;
  Markup out = section_start("raw", "Indication before correction");
  if (b.taxels.empty()) {
    out +=
        markup("<p>not available: {}</p>\n", Text(input.history.presses ? "the run pressed with an indenter; see the "
                                                                          "object’s figures"
                                                                        : "no taxel counts"));
    return out;
  }
  if (b.loops.empty()) {
    out += markup("<p>Loops and hysteresis: not assessed, no sequence rises and falls over the full range.</p>\n");
  }
  if (input.fit.taxels.empty() || input.evaluation.levels.empty()) out += trace_figures_raw(b, input.unit);
  if (!b.loops.empty()) {
    out += loops_figure(b, columns, input.unit);
    out += hysteresis_table(b, input.evaluation, columns);
    out += gain_figures(b, rows, columns, input.unit);
  }
  out += repeatability_part(b, input.unit);
  out += zero_part(b, columns);
  out += creep_part(b, input.unit);
  return out;
}

}  // namespace tactbench::analysis
