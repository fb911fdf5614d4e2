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
Markup trace_triple(const TaxelTrace& trace, const std::string& model) {
  const std::string of = fmt::format("{}, sequence {}", trace.taxel.title, trace.sequence);
  Markup out =
      markup("<div class=\"keep\"><h4>Sequence {}</h4>\n<div class=\"triple\">\n", html::stated(trace.sequence));
  out += third({.title = "Output measured and by the direct model against pressure, " + of,
                .x_label = "pressure, psi",
                .y_label = "output, V",
                .series = {{"measured", trace.pressure_psi, trace.measured_v, 0},
                           {model, trace.pressure_psi, trace.model_v, 1}}},
               "Direct model.");
  out += third({.title = "Pressure measured and by the inverse model against output, " + of,
                .x_label = "output, V",
                .y_label = "pressure, psi",
                .series = {{"measured", trace.measured_v, trace.pressure_psi, 0},
                           {"inverse", trace.measured_v, trace.estimate_psi, 1}}},
               "Inverse model.");
  LineChart compensated{.title = "Pressure after compensation against reference pressure, " + of,
                        .x_label = "reference, psi",
                        .y_label = "compensated, psi",
                        .series = {{"compensated", trace.pressure_psi, trace.estimate_psi, 2, true}}};
  const Spread range = spread_of(trace.pressure_psi);
  if (range.count > 1)
    compensated.series.push_back({"ideal", {range.low, range.high}, {range.low, range.high}, 0, false});
  out += third(compensated, "Pressure after compensation.");
  out += markup("</div></div>\n");
  return out;
}

Markup trace_errors(const std::vector<TaxelTrace>& traces) {
  Markup out = markup(
      "<table><caption>Compensated against reference pressure, means of the repeats</caption><thead><tr>"
      "<th scope=\"col\">taxel</th><th scope=\"col\">sequence</th><th scope=\"col\" class=\"n\">steps</th>"
      "<th scope=\"col\" class=\"n\">mean error</th><th scope=\"col\" class=\"n\">maximum error</th></tr></thead>"
      "<tbody>\n");
  for (const TaxelTrace& trace : traces) {
    const Deviation error = deviation(trace.estimate_psi, trace.pressure_psi);
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td class=\"n\">{}</td>{}{}</tr>\n", Text(trace.taxel.title),
                  html::stated(trace.sequence), trace.pressure_psi.size(), number_cell(html::psi(error.mean, 3)),
                  number_cell(html::psi(error.maximum, 2)));
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

Markup compensation_section(const ReportInput& input) {
  Markup out = section_start("compensation", "Compensation of single taxels, usable range");
  const std::vector<TaxelTrace>& traces = input.more.traces;
  if (traces.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += usable_part(input);
  out += markup("<h3>Single taxels: direct, inverse, pressure against pressure</h3>\n");
  out += trace_errors(traces);
  int before = -2;
  for (const TaxelTrace& trace : traces) {
    if (trace.taxel.taxel != before) out += markup("<h3>The {}</h3>\n", Text(trace.taxel.title));
    before = trace.taxel.taxel;
    out += trace_triple(trace, model_name(input.fit));
  }
  out += markup(
      "<p class=\"note\">Every repeat was compensated frame by frame in the order in which it was measured; shown are "
      "the means of the repeats. The direct model is driven by the measured reference pressure, the inverse one by the "
      "measured output alone. The compensated mean taxel is the mean of the pressures of all fitted taxels, not the "
      "inverse of the mean output. Deviations at high pressure on the way down come from noise where the loop is "
      "flat.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
