#include <algorithm>
#include <cctype>
#include <cmath>

#include "analysis/identify/histories.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

std::string model_title(const std::string& model) {
  std::string title = model;
  for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return title;
}

// Measured and model against pressure, the residual below on the same axis.
Markup model_panel(const ComparedTaxel& taxel, const ComparedSequence& sequence, const ComparedModel& model,
                   PressureUnit unit) {
  const std::string of = fmt::format("{}, {}, sequence {}", model_title(model.model), taxel.taxel.title, sequence.name);
  if (!model.failed.empty()) {
    return markup("<figure><p>{}: not available, {}</p></figure>\n", Text(model_title(model.model)),
                  Text(model.failed));
  }
  std::vector<double> residual_mv;
  for (std::size_t i = 0; i < model.model_v.size(); ++i)
    residual_mv.push_back(1000.0 * (model.model_v[i] - sequence.measured_v[i]));
  Markup out =
      markup("<figure>{}",
             line_chart(pressure_along({.title = "Output measured and by the model against pressure: " + of,
                                        .x_label = "gauge pressure",
                                        .y_label = "output in V",
                                        .series = {{"measured", sequence.pressure_psi, sequence.measured_v, 0},
                                                   {model_title(model.model), sequence.pressure_psi, model.model_v, 1}},
                                        .width = 335,
                                        .height = 225},
                                       unit)));
  out += line_chart(pressure_along({.title = "Lack of fit, model minus measured: " + of,
                                    .x_label = "gauge pressure",
                                    .y_label = "residual in mV",
                                    .series = {{"model minus measured", sequence.pressure_psi, residual_mv, 2, true}},
                                    .width = 335,
                                    .height = 140},
                                   unit));
  out += markup("<figcaption>{}: mean error {} % FS, maximum {} % FS.</figcaption></figure>\n",
                Text(model_title(model.model)), html::percent(model.mean_error_v / taxel.full_scale_v, 2),
                html::percent(model.max_error_v / taxel.full_scale_v, 2));
  return out;
}

Markup sequence_panels(const ComparedTaxel& taxel, const ComparedSequence& sequence, PressureUnit unit) {
  Markup out;
  for (std::size_t first = 0; first < sequence.models.size(); first += 2) {
    out += markup("<div class=\"keep\">");
    if (first == 0) out += markup("<h4>Sequence {}</h4>\n", html::stated(sequence.name));
    out += markup("<div class=\"pair\">\n");
    for (std::size_t i = first; i < std::min(first + 2, sequence.models.size()); ++i)
      out += model_panel(taxel, sequence, sequence.models[i], unit);
    out += markup("</div></div>\n");
  }
  return out;
}

// Of a single taxel: ELAM's panel, and the residuals of all four models step by step (Figs 11, 12).
Markup elam_and_residuals(const ComparedTaxel& taxel, const ComparedSequence& sequence, PressureUnit unit) {
  const std::string of = fmt::format("{}, sequence {}", taxel.taxel.title, sequence.name);
  LineChart chart{.title = "Residuals of the four models, model minus measured, step by step: " + of,
                  .x_label = "step",
                  .y_label = "residual in mV",
                  .series = {},
                  .width = 335,
                  .height = 340};
  int style = 1;
  for (const ComparedModel& model : sequence.models) {
    Series series{model_title(model.model), {}, {}, model.model == "elam" ? 0 : style++};
    for (std::size_t i = 0; i < model.model_v.size(); ++i) {
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(1000.0 * (model.model_v[i] - sequence.measured_v[i]));
    }
    if (model.failed.empty()) chart.series.push_back(std::move(series));
  }
  Markup out = markup("<div class=\"keep\"><h4>Sequence {}</h4>\n<div class=\"pair\">\n", html::stated(sequence.name));
  out += model_panel(taxel, sequence, sequence.models.back(), unit);
  out += markup("<figure>{}<figcaption>All models, step by step.</figcaption></figure>\n</div></div>\n",
                line_chart(chart));
  return out;
}

Markup error_row(const ComparedSequence& sequence, const ComparedModel& model, double full_scale_v,
                 const char* remark) {
  Markup out = markup("<tr><th scope=\"row\">{}</th><td>{}{}</td>", html::stated(sequence.name),
                      Text(model_title(model.model)), Text(remark));
  if (!model.failed.empty()) {
    out += markup("<td colspan=\"7\">not available: {}</td></tr>\n", Text(model.failed));
    return out;
  }
  out += number_cell(html::fixed(model.j_v2, 4));
  out += number_cell(html::fixed(model.mean_error_v, 4));
  out += number_cell(html::percent(model.mean_error_v / full_scale_v, 2));
  out += number_cell(html::fixed(model.max_error_v, 4));
  out += number_cell(html::percent(model.max_error_v / full_scale_v, 2));
  out += number_cell(html::percent(model.mean_running_v / full_scale_v, 2));
  out += number_cell(html::percent(model.max_running_v / full_scale_v, 2));
  out += markup("</tr>\n");
  return out;
}

Markup errors_of_models(const ComparedTaxel& taxel) {
  Markup out = markup(
      "<table><caption>Errors of the direct models, {}; FS is {} V, of this taxel’s external loop {}</caption>"
      "<thead><tr><th scope=\"col\">sequence</th><th scope=\"col\">model</th>"
      "<th scope=\"col\" class=\"n\">J, V²</th><th scope=\"col\" class=\"n\">mean, V</th>"
      "<th scope=\"col\" class=\"n\">mean, % FS</th><th scope=\"col\" class=\"n\">maximum, V</th>"
      "<th scope=\"col\" class=\"n\">maximum, % FS</th><th scope=\"col\" class=\"n\">free running, mean, % FS</th>"
      "<th scope=\"col\" class=\"n\">free running, maximum, % FS</th></tr></thead><tbody>\n",
      Text(taxel.taxel.title), html::fixed(taxel.full_scale_v, 3), Text(kFullScaleOfModel));
  for (const ComparedSequence& sequence : taxel.sequences) {
    // Like with like: one set of parameters for all sequences cannot be as close to one of them as a set of its own.
    const ComparedModel* best = nullptr;
    const bool joint = std::ranges::any_of(sequence.models, &ComparedModel::joint);
    for (const ComparedModel& model : sequence.models)
      if (model.failed.empty() && !model.joint && (best == nullptr || model.mean_error_v < best->mean_error_v))
        best = &model;
    for (const ComparedModel& model : sequence.models)
      out += error_row(sequence, model, taxel.full_scale_v,
                       model.joint      ? " (one set for all sequences)"
                       : &model != best ? ""
                       : joint          ? " (least mean error of the sets for this sequence alone)"
                                        : " (least mean error)");
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup sizes_of_models(const ComparedTaxel& taxel) {
  Markup out = markup(
      "<table><caption>Size of the models</caption><thead><tr><th scope=\"col\">model</th>"
      "<th scope=\"col\" class=\"n\">parameters identified</th><th scope=\"col\" class=\"n\">operations a sample</th>"
      "<th scope=\"col\">what it needs besides</th></tr></thead><tbody>\n");
  for (const ComparedModel& model : taxel.sequences.front().models) {
    if (!model.failed.empty()) continue;
    const auto identified = model.parameters.size() - static_cast<std::size_t>(std::ranges::count(
                                                          model.parameters, true, &ModelParameter::fixed));
    const char* besides = model.model == "elam"   ? "two pattern curves, the measured external loop"
                          : model.model == "gpi"  ? "exponentials of the envelopes; 5 play operators"
                          : model.model == "mpi"  ? "11 play operators"
                          : model.model == "poly" ? "the ends of the external loop"
                                                  : "";
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
                  Text(model_title(model.model)), identified, model.operations_per_sample, Text(besides));
  }
  out += markup("</tbody></table>\n");
  return out;
}

// Tables 2, 3: the mean taxel's parameters on one sequence, a pair of columns a model.
Markup parameters_of_models(const ComparedTaxel& taxel, const ComparedSequence& sequence) {
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Parameters, sequence {}\"><table><caption>"
      "Parameters, {}, sequence {}</caption><thead><tr>",
      html::Attribute(sequence.name), Text(taxel.taxel.title), html::stated(sequence.name));
  std::size_t most = 0;
  for (const ComparedModel& model : sequence.models) {
    out += markup("<th scope=\"colgroup\" colspan=\"2\">{}</th>", Text(model_title(model.model)));
    most = std::max(most, model.parameters.size());
  }
  out += markup("</tr></thead><tbody>\n");
  for (std::size_t i = 0; i < most; ++i) {
    out += markup("<tr>");
    for (const ComparedModel& model : sequence.models) {
      if (i >= model.parameters.size()) {
        out += markup("<td></td><td></td>");
        continue;
      }
      const ModelParameter& parameter = model.parameters[i];
      const html::Text value =
          std::abs(parameter.value) < 1e-3 && parameter.value != 0.0
              ? Text(fmt::format("{}{:.3e}", parameter.value < 0.0 ? "−" : "", std::abs(parameter.value)))
              : html::fixed(parameter.value, 4);
      const char* mark = parameter.fixed ? " (fixed)" : parameter.at_bound() ? " (bound)" : "";
      out += markup("<td>{}{}</td>{}", Text(parameter.name), Text(mark), number_cell(value));
    }
    out += markup("</tr>\n");
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

}  // namespace

Markup models_section(const ReportInput& input) {
  const ModelComparison& comparison = input.more.models;
  Markup out = section_start("models", "Hysteresis models compared");
  if (comparison.taxels.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  const bool joint = comparison.taxels.front().sequences.front().models.back().joint;
  out += markup(
      "<p>{} GPI, MPI and POLY were "
      "identified when this report was made, for the taxels shown here alone, with parameters of their own for each "
      "sequence, as in the publication. All models go along the set-points, the outputs of the repeats are averaged, "
      "and every branch starts at its measured output; free running it starts at the model’s own. GPI and MPI know the "
      "inputs alone and are the same both ways.</p>\n",
      Text(joint
               ? "ELAM is the stored fit of this run: one set of parameters for all sequences, which no sequence alone "
                 "decides; it is therefore not ranked among the others."
               : "ELAM has parameters of this sequence, as the others have."));
  out += sizes_of_models(comparison.taxels.front());
  for (const ComparedTaxel& taxel : comparison.taxels) {
    out += markup("<h3>The {}</h3>\n", Text(taxel.taxel.title));
    out += errors_of_models(taxel);
    const bool mean = taxel.taxel.taxel == kMeanTaxel;
    for (const ComparedSequence& sequence : taxel.sequences)
      out += mean ? sequence_panels(taxel, sequence, input.unit) : elam_and_residuals(taxel, sequence, input.unit);
    if (!mean) continue;
    for (const ComparedSequence& sequence : taxel.sequences) out += parameters_of_models(taxel, sequence);
  }
  out += markup(
      "<p class=\"note\">Best, median and worst: by the mean absolute error of the taxel. J: Eq. (1), the sum of "
      "squared differences; mean error: Eq. (49); the first sample of a branch, its turning point, is not counted. "
      "Operations: additions, multiplications, comparisons and look-ups of one sample between turns, counted by hand. "
      "Fixed parameters are set by convention and are not identified: in GPI a0 holds the factor e^a2 and b0 holds "
      "e^b2, "
      "and rho = 1 sets the common scale of the others. The parameters of the other taxels stand in the data of this "
      "file.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
