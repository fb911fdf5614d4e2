#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

struct TraceErrors {
  Deviation model, compensated;
};

TraceErrors errors_of(const Trace& trace) {
  return {deviation(trace.model_v, trace.measured_v), deviation(trace.compensated_psi, trace.pressure_psi)};
}

Markup figure(const LineChart& chart, const std::string& caption) {
  return markup("<figure>{}<figcaption>{}</figcaption></figure>\n", line_chart(chart), Text(caption));
}

// `model`: its name.
Markup trace_figures(const Trace& trace, const std::string& model, PressureUnit unit) {
  const std::string of = "mean taxel, sequence " + trace.sequence;
  Markup out = markup("<div class=\"keep\"><h3>Sequence {}</h3>\n<div class=\"pair\">\n", html::stated(trace.sequence));
  out +=
      figure(pressure_along(
                 {.title = fmt::format("Output voltage measured and by the {} model against pressure, {}", model, of),
                  .x_label = "reference value",
                  .y_label = "output in V",
                  .series = {{"measured", trace.pressure_psi, trace.measured_v, 0, false},
                             {model + " model", trace.pressure_psi, trace.model_v, 1, false}},
                  .width = 335,
                  .height = 265},
                 unit),
             "Measured output and direct model.");
  LineChart compensated{.title = "Corrected indication against reference value, " + of,
                        .x_label = "reference value",
                        .y_label = "corrected indication",
                        .series = {{"corrected", trace.pressure_psi, trace.compensated_psi, 2, true}},
                        .width = 335,
                        .height = 265};
  const Spread range = spread_of(trace.pressure_psi);
  if (range.count > 1) {
    compensated.series.push_back({"ideal", {range.low, range.high}, {range.low, range.high}, 0, false});
  }
  out += figure(pressures(std::move(compensated), unit),
                "Corrected indication (inverse model) against the reference value.");
  out += markup("</div></div>\n");
  std::vector<double> residual_mv;
  for (std::size_t i = 0; i < trace.pressure_psi.size() && i < trace.model_v.size() && i < trace.measured_v.size();
       ++i) {
    residual_mv.push_back(1000.0 * (trace.model_v[i] - trace.measured_v[i]));
  }
  std::vector<double> at(trace.pressure_psi.begin(),
                         trace.pressure_psi.begin() + static_cast<std::ptrdiff_t>(residual_mv.size()));
  out += figure(pressure_along({.title = fmt::format("Lack of fit of the {} model against pressure, {}", model, of),
                                .x_label = "reference value",
                                .y_label = "residual in mV",
                                .series = {{"model minus measured", at, residual_mv, 1, true}},
                                .width = 682,
                                .height = 180},
                               unit),
                "Lack of fit: model minus measured, one dot a step.");
  return out;
}

}  // namespace

Markup loops_section(const ReportInput& input) {
  Markup out = section_start("loops", "Loops of the mean taxel");
  if (input.evaluation.traces.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  for (const Trace& trace : input.evaluation.traces) {
    out += trace_figures(trace, model_name(input.fit), input.unit);
  }
  const double full_scale = input.evaluation.full_scale_v;
  out += markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Errors by sequence\"><table><caption>Errors of "
      "the mean taxel by sequence</caption><thead><tr>"
      "<th scope=\"col\" rowspan=\"2\">sequence</th><th scope=\"col\" rowspan=\"2\" class=\"n\">steps</th>"
      "<th scope=\"colgroup\" colspan=\"4\">direct model against measured output</th>"
      "<th scope=\"colgroup\" colspan=\"2\">corrected indication less reference value</th></tr><tr>"
      "<th scope=\"col\" class=\"n\">mean, V</th><th scope=\"col\" class=\"n\">mean, % FS</th>"
      "<th scope=\"col\" class=\"n\">maximum, V</th><th scope=\"col\" class=\"n\">maximum, % FS</th>"
      "<th scope=\"col\" class=\"n\">mean |error|</th><th scope=\"col\" "
      "class=\"n\">maximum</th></tr></thead><tbody>\n");
  for (const Trace& trace : input.evaluation.traces) {
    const TraceErrors errors = errors_of(trace);
    out +=
        markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td>{}{}{}{}{}{}</tr>\n", html::stated(trace.sequence),
               trace.pressure_psi.size(), number_cell(html::fixed(errors.model.mean, 4)),
               number_cell(html::percent(errors.model.mean / full_scale, 2)),
               number_cell(html::fixed(errors.model.maximum, 4)),
               number_cell(html::percent(errors.model.maximum / full_scale, 2)),
               number_cell(html::pressure(errors.compensated.mean, input.unit, 2)),
               number_cell(html::pressure(errors.compensated.maximum, input.unit, 2)));
  }
  out += markup("</tbody></table></div>\n<p class=\"note\">FS: highest mean output of the array, {} V.</p>\n",
                html::fixed(full_scale, 3));
  return out;
}

}  // namespace tactbench::analysis
