#include <algorithm>
#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr double kThirdWidth = 226.0, kThirdHeight = 205.0;

Markup third(LineChart chart, const char* caption) {
  chart.width = kThirdWidth;
  chart.height = kThirdHeight;
  return markup("<figure>{}<figcaption>{}</figcaption></figure>\n", line_chart(chart), Text(caption));
}

// Figs 13, 14: direct model, inverse model, pressure against pressure. `model`: its name.
Markup trace_triple(const TaxelTrace& trace, const std::string& model, PressureUnit unit) {
  const std::string of = fmt::format("{}, sequence {}", trace.taxel.title, trace.sequence);
  Markup out =
      markup("<div class=\"keep\"><h4>Sequence {}</h4>\n<div class=\"triple\">\n", html::stated(trace.sequence));
  out += third(pressure_along({.title = "Output measured and by the direct model against pressure, " + of,
                               .x_label = "pressure",
                               .y_label = "output in V",
                               .series = {{"measured", trace.pressure_psi, trace.measured_v, 0},
                                          {model, trace.pressure_psi, trace.model_v, 1}},
                               .width = kThirdWidth},
                              unit),
               "Direct model.");
  out += third(pressure_up({.title = "Pressure measured and by the inverse model against output, " + of,
                            .x_label = "output in V",
                            .y_label = "pressure",
                            .series = {{"measured", trace.measured_v, trace.pressure_psi, 0},
                                       {"inverse", trace.measured_v, trace.estimate_psi, 1}},
                            .width = kThirdWidth},
                           unit),
               "Inverse model.");
  LineChart compensated{.title = "Corrected indication against reference value, " + of,
                        .x_label = "reference",
                        .y_label = "corrected",
                        .series = {{"corrected", trace.pressure_psi, trace.estimate_psi, 2, true}},
                        .width = kThirdWidth};
  const Spread range = spread_of(trace.pressure_psi);
  if (range.count > 1)
    compensated.series.push_back({"ideal", {range.low, range.high}, {range.low, range.high}, 0, false});
  out += third(pressures(std::move(compensated), unit), "Corrected indication.");
  out += markup("</div></div>\n");
  return out;
}

Markup trace_errors(const std::vector<TaxelTrace>& traces, PressureUnit unit) {
  Markup out = markup(
      "<table><caption>Corrected indication less reference value, means of the repeats</caption><thead><tr>"
      "<th scope=\"col\">taxel</th><th scope=\"col\">sequence</th><th scope=\"col\" class=\"n\">steps</th>"
      "<th scope=\"col\" class=\"n\">mean |error|</th><th scope=\"col\" class=\"n\">maximum |error|</th></tr></thead>"
      "<tbody>\n");
  for (const TaxelTrace& trace : traces) {
    const Deviation error = deviation(trace.estimate_psi, trace.pressure_psi);
    out +=
        markup("<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"n\">{}</td>{}{}</tr>\n", Text(trace.taxel.title),
               html::stated(trace.sequence), trace.pressure_psi.size(),
               number_cell(html::pressure(error.mean, unit, 3)), number_cell(html::pressure(error.maximum, unit, 2)));
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

Markup compensation_section(const ReportInput& input) {
  Markup out = section_start("compensation", "Correction of single taxels, condition of the inverse");
  const std::vector<TaxelTrace>& traces = input.more.traces;
  if (traces.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += usable_part(input);
  out += markup("<h3>Single taxels: direct, inverse, pressure against pressure</h3>\n");
  out += trace_errors(traces, input.unit);
  int before = -2;
  for (const TaxelTrace& trace : traces) {
    if (trace.taxel.taxel != before) out += markup("<h3>The {}</h3>\n", Text(trace.taxel.title));
    before = trace.taxel.taxel;
    out += trace_triple(trace, model_name(input.fit), input.unit);
  }
  out += markup(
      "<p class=\"note\">Every repeat was corrected frame by frame in the order in which it was measured; shown are "
      "the means of the repeats. The direct model is driven by the measured reference value, the inverse one by the "
      "measured output alone. The corrected mean taxel is the mean of the pressures of all fitted taxels, not the "
      "inverse of the mean output. Deviations at high decreasing pressure come from noise where the loop is "
      "flat.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
