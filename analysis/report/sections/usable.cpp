#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

Markup pressure_range(double low, double high, PressureUnit unit) {
  if (!(low <= high)) return markup("none");
  return markup("{} to {}", html::pressure(low, unit, 1), html::pressure(high, unit, 1));
}

std::vector<double> in_percent(const std::vector<double>& shares) {
  std::vector<double> out;
  for (const double share : shares) out.push_back(100.0 * share);
  return out;
}

Markup usable_charts(const UsableRange& range, PressureUnit unit) {
  const auto series = [&](const char* name, const std::vector<double>& values, int style) {
    return Series{name, range.pressure_psi, values, style};
  };
  Markup out = markup(
      "<div class=\"pair\">\n<figure>{}<figcaption>Taxels that meet the rule at a level.</figcaption></figure>\n",
      line_chart(pressure_along(
          {.title = "Share of the fitted taxels that meet the rule by noise, and by noise and model error",
           .x_label = "gauge pressure",
           .y_label = "share of taxels in %",
           .series = {series("incr., noise", in_percent(range.loading.resolved_share), 1),
                      series("incr., noise and model", in_percent(range.loading.usable_share), 2),
                      series("decr., noise", in_percent(range.unloading.resolved_share), 4),
                      series("decr., noise and model", in_percent(range.unloading.usable_share), 3)},
           .width = 335,
           .height = 280,
           .y_from_zero = true},
          unit)));
  out += markup(
      "<figure>{}<figcaption>By how much an output off by noise and model error moves the pressure.</figcaption>"
      "</figure>\n</div>\n",
      line_chart(
          pressures({.title = "Pressure by which an output off by noise and model error moves the inverse, per level",
                     .x_label = "gauge pressure",
                     .y_label = "moved by",
                     .series = {series("incr., median taxel", range.loading.median_psi, 1),
                                series("incr., worst", range.loading.worst_psi, 2),
                                series("decr., median taxel", range.unloading.median_psi, 4),
                                series("decr., worst", range.unloading.worst_psi, 3)},
                     .width = 335,
                     .height = 280,
                     .y_from_zero = true},
                    unit)));
  return out;
}

}  // namespace

Markup usable_part(const ReportInput& input) {
  const UsableRange& range = input.more.usable;
  Markup out = markup("<h3>Condition of the inverse</h3>\n");
  if (range.pressure_psi.empty() || range.taxels == 0) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += markup(
      "<p>A property of the model alone, without its uncertainty: the measuring interval, in which U of 95 % of the "
      "taxels is within a stated limit, stands in the section Uncertainty. The rule here: a taxel discriminates at a "
      "level of its external loop when an output that is off by {} standard deviations of one sample’s noise moves the "
      "pressure of the inverse by at most {}; in spite of the model’s error it does so when the same holds for an "
      "output off by the root sum of squares of that and the taxel’s mean model error. Given are the longest rows of "
      "levels at which at least {} % of the {} fitted taxels meet the rule.</p>\n",
      html::fixed(range.options.in_noises, 0), html::pressure(range.options.most_psi, input.unit, 1),
      html::percent(range.options.least_share, 0), range.taxels);
  out += markup(
      "<table><caption>Pressures at which the inverse is well-conditioned</caption><thead><tr><th "
      "scope=\"col\">pressure</th><th scope=\"col\">discrimination in spite of "
      "noise</th><th scope=\"col\">in spite of noise and model error</th></tr></thead><tbody>\n");
  for (const bool up : {true, false}) {
    const UsableBranch& branch = up ? range.loading : range.unloading;
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n", Text(branch_in_words(up)),
                  pressure_range(branch.resolved_low_psi, branch.resolved_high_psi, input.unit),
                  pressure_range(branch.low_psi, branch.high_psi, input.unit));
  }
  out += markup("</tbody></table>\n");
  out += usable_charts(range, input.unit);
  out += markup(
      "<p class=\"note\">The inverse is clamped to the range of the external loop, so that its two ends look better "
      "conditioned than they are. Inner branches are flatter or steeper than the external ones in places.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
