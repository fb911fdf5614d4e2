// U by condition of use: what it covers, on what it rests, and what it is not valid for.
#include <algorithm>

#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

bool has_conditions(const ReportInput& input) { return input.uncertainty && !input.uncertainty->conditions.empty(); }

Markup condition_row(const ConditionUncertainty& condition, PressureUnit unit) {
  Markup out = markup("<tr><th scope=\"row\">{}</th>", Text(condition.name));
  if (!condition.valid()) {
    out += markup("<td colspan=\"3\">not valid for this: {}</td></tr>\n", Text(condition.not_valid));
    return out;
  }
  std::vector<double> sorted = finite_of(condition.expanded_psi);
  std::ranges::sort(sorted);
  out += number_cell(gum_pressure(condition.median_psi, unit));
  out += number_cell(gum_pressure(quantile_between(sorted, 0.95), unit));
  out += markup("<td>{}</td></tr>\n", Text(condition.basis));
  return out;
}

std::string names_of(const Uncertainty& uncertainty, bool valid) {
  std::string names;
  for (const ConditionUncertainty& condition : uncertainty.conditions) {
    if (condition.valid() != valid) continue;
    names += names.empty() ? "" : "; ";
    names += condition.name;
  }
  return names;
}

}  // namespace

Markup conditions_part(const ReportInput& input) {
  if (!has_conditions(input)) return {};
  Markup out = markup(
      "<div class=\"wide keep\"><table class=\"levels even\"><caption>U of one corrected indication by condition of "
      "use</caption><thead><tr><th scope=\"col\">condition</th><th scope=\"col\" class=\"n\">median "
      "</th><th scope=\"col\" class=\"n\">95 % of levels and taxels are below</th><th scope=\"col\">rests "
      "on</th></tr></thead><tbody>\n");
  for (const ConditionUncertainty& condition : input.uncertainty->conditions)
    out += condition_row(condition, input.unit);
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">A condition that is named “not valid for this” was not assessed: no U "
      "of "
      "this report covers it. Two conditions at once, such as another dwell after re-mounting, are covered by the "
      "budgets below, which contain all that was assessed. Median and largest U at each level under each condition "
      "stand in the data of this file.</p>\n");
  return out;
}

Markup conditions_in_brief(const ReportInput& input) {
  if (!has_conditions(input)) return {};
  const std::string valid = names_of(*input.uncertainty, true), not_valid = names_of(*input.uncertainty, false);
  return markup(
      "<p class=\"note\">U of a reading (<a href=\"#uncertainty\">Uncertainty</a>) is valid for: {}. Not valid "
      "for: {}.</p>\n",
      Text(valid.empty() ? "nothing" : valid), Text(not_valid.empty() ? "uses that are not named here" : not_valid));
}

}  // namespace tactbench::analysis
