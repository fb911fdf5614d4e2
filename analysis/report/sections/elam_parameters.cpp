#include <algorithm>
#include <array>
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

constexpr std::size_t kElamParameters = kElamParameterNames.size();

double elam_parameter(const ModelTaxel& taxel, std::size_t parameter) {
  const ElamParameters& p = elam_of(taxel)->parameters;
  return std::array<double, kElamParameters>{p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a}[parameter];
}

// All taxels; NaN where none is fitted.
std::vector<double> elam_values(const SensorModel& fit, std::size_t parameter) {
  std::vector<double> out;
  for (const ModelTaxel& taxel : fit.array())
    out.push_back(taxel.status == TaxelStatus::kFitted ? elam_parameter(taxel, parameter) : kNan);
  return out;
}

// Outline of the numbers of taxels in equal bins.
Markup parameter_histogram(const std::string& name, const std::string& label, const std::vector<double>& values,
                           const Spread& spread) {
  constexpr int kParameterBins = 24;
  const double width = (spread.high > spread.low ? spread.high - spread.low : 1e-6) / kParameterBins;
  std::array<double, kParameterBins> counts{};
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    ++counts[static_cast<std::size_t>(
        std::clamp(static_cast<int>((value - spread.low) / width), 0, kParameterBins - 1))];
  }
  Series outline{"taxels", {spread.low}, {0.0}, 0};
  for (int bin = 0; bin < kParameterBins; ++bin) {
    for (const int edge : {bin, bin + 1}) {
      outline.x.push_back(spread.low + width * edge);
      outline.y.push_back(counts[static_cast<std::size_t>(bin)]);
    }
  }
  outline.x.push_back(spread.low + width * kParameterBins);
  outline.y.push_back(0.0);
  return line_chart({.title = fmt::format("Histogram of {} over the taxels", name),
                     .x_label = label,
                     .y_label = "taxels",
                     .series = {outline},
                     .width = 335,
                     .height = 215,
                     .y_from_zero = true});
}

Markup parameter_row(const SensorModel& fit, std::size_t parameter) {
  const std::vector<double> values = elam_values(fit, parameter);
  const Spread spread = spread_of(values);
  const std::string name = kElamParameterNames[parameter], unit = parameter == 2 ? ", 1/psi" : "";
  const ColourScale scale{spread.low, spread.high > spread.low ? spread.high : spread.low + 1e-9};
  const int digits = parameter == 2 ? 4 : 3;
  Markup out = markup("<div class=\"beside\">\n<figure class=\"narrow\">{}",
                      frame_map({fmt::format("{} of each taxel", name), fit.rows, fit.columns, values, scale, 190.0}));
  out += colour_bar(scale, fmt::format("Colour scale of {}", name), "", digits);
  out += markup("<figcaption>{} over the array{}.</figcaption></figure>\n", Text(name), Text(unit));
  out += markup(
      "<figure class=\"narrow\">{}<figcaption>{}: minimum {}, median {}, maximum {}.</figcaption></figure>\n</div>\n",
      parameter_histogram(name, name + unit, values, spread), Text(name), html::fixed(spread.low, digits),
      html::fixed(spread.median, digits), html::fixed(spread.high, digits));
  return out;
}

Markup bounds_table(const SensorModel& fit) {
  Markup rows;
  for (std::size_t parameter = 0; parameter < kElamParameters; ++parameter) {
    std::string places;
    int count = 0;
    for (std::size_t i = 0; i < fit.array().size(); ++i) {
      const ModelTaxel& taxel = fit.taxels[i];
      if (taxel.status != TaxelStatus::kFitted || ((taxel.fit.at_bound >> parameter) & 1u) == 0) continue;
      ++count;
      places += fmt::format("{}({}, {})", places.empty() ? "" : " ", i / static_cast<std::size_t>(fit.columns),
                            i % static_cast<std::size_t>(fit.columns));
    }
    rows += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td></tr>\n",
                   Text(kElamParameterNames[parameter]), count, Text(places.empty() ? "none" : places));
  }
  return markup(
      "<table><caption>Taxels with a parameter at a bound of the search</caption><thead><tr><th "
      "scope=\"col\">parameter</th>"
      "<th scope=\"col\" class=\"n\">taxels</th><th scope=\"col\">(row, "
      "column)</th></tr></thead><tbody>\n{}</tbody></table>\n",
      rows);
}

}  // namespace

Markup elam_parameters_part(const ReportInput& input) {
  Markup out = markup("<h3>Parameters over the array</h3>\n");
  if (fitted_taxels(input.fit) == 0) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  for (std::size_t parameter = 0; parameter < kElamParameters; ++parameter) out += parameter_row(input.fit, parameter);
  out += bounds_table(input.fit);
  out += markup(
      "<p class=\"note\">Row 0 on top, column 0 on the left; a cross marks a taxel without a model. alpha_d, beta_d, "
      "beta_a and the relative split alpha_a1 L + alpha_a0 are searched in 0 to 1; a parameter at a bound means that "
      "the best split lies at an end of the branch.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
