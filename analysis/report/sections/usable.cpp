#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

Markup pressure_range(double low, double high) {
  if (!(low <= high)) return markup("none");
  return markup("{} to {}", html::psi(low, 1), html::psi(high, 1));
}

std::vector<double> in_percent(const std::vector<double>& shares) {
  std::vector<double> out;
  for (const double share : shares) out.push_back(100.0 * share);
  return out;
}

Markup usable_charts(const UsableRange& range) {
  const auto series = [&](const char* name, const std::vector<double>& values, int style) {
    return Series{name, range.pressure_psi, values, style};
  };
  Markup out = markup(
      "<div class=\"pair\">\n<figure>{}<figcaption>Taxels that meet the rule at a level.</figcaption></figure>\n",
      line_chart({.title = "Share of the fitted taxels whose inverse is resolved and usable per level",
                  .x_label = "pressure in psi",
                  .y_label = "share of taxels in %",
                  .series = {series("up, resolved", in_percent(range.loading.resolved_share), 1),
                             series("up, usable", in_percent(range.loading.usable_share), 2),
                             series("down, resolved", in_percent(range.unloading.resolved_share), 4),
                             series("down, usable", in_percent(range.unloading.usable_share), 3)},
                  .width = 335,
                  .height = 255,
                  .y_from_zero = true}));
  out += markup(
      "<figure>{}<figcaption>By how much an output off by noise and model error moves the pressure.</figcaption>"
      "</figure>\n</div>\n",
      line_chart({.title = "Pressure by which an output off by noise and model error moves the inverse, per level",
                  .x_label = "pressure in psi",
                  .y_label = "moved by, psi",
                  .series = {series("up, median taxel", range.loading.median_psi, 1),
                             series("up, worst", range.loading.worst_psi, 2),
                             series("down, median taxel", range.unloading.median_psi, 4),
                             series("down, worst", range.unloading.worst_psi, 3)},
                  .width = 335,
                  .height = 255,
                  .y_from_zero = true}));
  return out;
}

}  // namespace

Markup usable_part(const ReportInput& input) {
  const UsableRange& range = input.more.usable;
  Markup out = markup("<h3>Usable range</h3>\n");
  if (range.pressure_psi.empty() || range.taxels == 0) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += markup(
      "<p>The rule: a taxel is “resolved” at a level of its external loop when an output that is off by {} "
      "standard deviations of one sample’s noise moves the pressure of the inverse by at most {}. It is “usable” "
      "when the same holds for an output off by the root sum of squares of that and the taxel’s mean model error. The "
      "range is the longest row of levels at which at least {} % of the {} fitted taxels meet the rule.</p>\n",
      html::fixed(range.options.in_noises, 0), html::psi(range.options.most_psi, 1),
      html::percent(range.options.least_share, 0), range.taxels);
  out += markup(
      "<table><caption>Range in which the inverse is well-conditioned</caption><thead><tr><th scope=\"col\">branch</th>"
      "<th scope=\"col\">resolved (noise)</th><th scope=\"col\">usable (noise and model "
      "error)</th></tr></thead><tbody>\n");
  for (const auto& [name, branch] : {std::pair{"loading", &range.loading}, std::pair{"unloading", &range.unloading}}) {
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n", Text(name),
                  pressure_range(branch->resolved_low_psi, branch->resolved_high_psi),
                  pressure_range(branch->low_psi, branch->high_psi));
  }
  out += markup("</tbody></table>\n");
  out += usable_charts(range);
  out += markup(
      "<p class=\"note\">The inverse is clamped to the range of the external loop, so that its two ends look better "
      "conditioned than they are. Inner branches are flatter or steeper than the external ones in places.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
