#include <algorithm>
#include <cmath>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

// A share of full scale reads better in per cent; a pressure is shown in the page's unit and the other one.
// Beside a known U the value has its decimal place (gum_numbers.h).
Markup with_unit(double value, Quantity quantity, PressureUnit shown, double expanded = 0.0) {
  if (!std::isfinite(value)) return markup("not available");
  const bool known = std::isfinite(expanded) && expanded > 0.0;
  if (quantity == Quantity::kPressure)
    return known ? gum_pressure_value(value, expanded, shown) : markup("{}", html::pressure(value, shown, 3));
  if (quantity == Quantity::kShareOfFullScale)
    return markup("{}\u00A0%\u00A0FS", html::percent(value, known ? gum_decimals(100.0 * expanded) : 2));
  return markup("{} {}", html::significant(value, 5), Text(value == 1.0 ? "taxel" : "taxels"));
}

std::string titles_judged(const ReportInput& input) {
  std::vector<std::string> names;
  for (const JudgedColumn& run : judged_runs(input)) names.push_back(run.title);
  return fmt::format("{}", fmt::join(names, "; "));
}

// Each rule used, once.
Markup rules_in_words(const std::vector<JudgedFigure>& figures) {
  std::vector<DecisionRule> rules;
  Markup out;
  for (const JudgedFigure& figure : figures) {
    if (std::ranges::find(rules, figure.rule) != rules.end()) continue;
    rules.push_back(figure.rule);
    out += markup("<p>Decision rule {}.</p>\n", stated(rule_in_words(figure.rule)));
  }
  return out;
}

Markup uncertainty_cell(const JudgedFigure& figure, PressureUnit shown) {
  const double expanded = figure.u.expanded;
  if (std::isnan(expanded)) return number_cell(Text("not known"));
  if (expanded == 0.0) return number_cell(Text("0"));
  if (quantity_of(figure.criterion) == Quantity::kPressure) return number_cell(gum_pressure(expanded, shown));
  // As the value beside it: shares in per cent.
  return number_cell(markup("{}\u00A0%\u00A0FS", gum_uncertainty(100.0 * expanded)));
}

// How U of each criterion is formed, or why it is not known; once a criterion.
Markup uncertainties_in_words(const ReportInput& input) {
  Markup rows;
  std::vector<Criterion> stated_already;
  for (const JudgedFigure& figure : input.judgement.figures) {
    if (std::ranges::find(stated_already, figure.criterion) != stated_already.end()) continue;
    if (figure.u.basis.empty() && figure.u.missing.empty()) continue;
    stated_already.push_back(figure.criterion);
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}{}</td></tr>\n", Text(in_words(figure.criterion)),
                   Text(figure.u.missing.empty() ? "" : "not known: "),
                   Text(figure.u.missing.empty() ? figure.u.basis : figure.u.missing));
  }
  if (rows.value.empty()) return rows;
  return markup(
      "<table class=\"pairs\"><caption>How U of each judged figure is evaluated</caption><tbody>\n{}</tbody></table>\n"
      "<p class=\"note\">U is that of the figure, a mean or a scatter over taxels, frames and levels, with a coverage "
      "probability of approximately 95 % (k for 95.45 %; JCGM 100, G.3, G.4); it is not that of one taxel’s corrected "
      "indication. A guard band of U tests one tolerance limit on one side: the risk beyond it is half of 4.55 %. What "
      "is not assessed for a corrected indication (section Uncertainty) is not in it either.</p>\n",
      rows);
}

// Facts that the requirements alone would hide from the signer of a pass.
Markup findings_in_brief(const Health& health) {
  std::vector<std::string> words;
  const auto left_out = std::ranges::count_if(health.findings, &TaxelHealth::excluded);
  if (left_out > 0)
    words.push_back(fmt::format("{} of {} taxels left out of every figure", left_out, health.rows * health.columns));
  if (const int noisy = health.count("noisy"); noisy > 0)
    words.push_back(fmt::format("{} noisy {}", noisy, noisy == 1 ? "taxel" : "taxels"));
  for (const SwappedLines& swap : health.swaps)
    words.push_back(fmt::format("{} {} and {} swapped", swap.rows ? "rows" : "columns", swap.first, swap.second));
  if (words.empty()) return {};
  return markup(
      "<p><span class=\"doubt\"><span class=\"sign\">▲</span> Found on the sensor:</span> {}; see <a "
      "href=\"#health\">Sensor health</a>. No requirement judges noise of a taxel or swapped lines.</p>\n",
      Text(fmt::format("{}", fmt::join(words, "; "))));
}

Markup criteria_of_one_run(const ReportInput& input) {
  Markup out = markup(
      "<table class=\"verdicts\"><caption>Requirements</caption><thead><tr><th scope=\"col\">requirement</th><th "
      "scope=\"col\">scope</th>"
      "<th scope=\"col\" class=\"n\">value</th><th scope=\"col\" class=\"n\">U</th><th scope=\"col\" "
      "class=\"n\">tolerance limit</th><th scope=\"col\">decision rule</th><th "
      "scope=\"col\">conformity</th></tr></thead><tbody>\n");
  for (const JudgedFigure& figure : input.judgement.figures) {
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}{}<td>{}</td><td>{}</td></tr>\n",
                  stated(in_words(figure.criterion)), stated(in_both_units(figure.scope, input.unit)),
                  number_cell(judged_value(figure, input.unit)), uncertainty_cell(figure, input.unit),
                  number_cell(judged_limit(figure, input.unit)), stated(to_string(figure.rule)),
                  judged_mark(input, figure));
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

Markup judged_value(const JudgedFigure& figure, PressureUnit unit) {
  return with_unit(figure.value, quantity_of(figure.criterion), unit, figure.u.expanded);
}

Markup judged_with_uncertainty(const JudgedFigure& figure, PressureUnit unit) {
  const double expanded = figure.u.expanded;
  if (!(expanded > 0.0) || !std::isfinite(figure.value)) return judged_value(figure, unit);  // a NaN is not
  const Quantity quantity = quantity_of(figure.criterion);
  if (quantity == Quantity::kPressure) return gum_pressure_stated(figure.value, expanded, unit);
  const double factor = quantity == Quantity::kShareOfFullScale ? 100.0 : 1.0;
  return markup("{} ± {}", judged_value(figure, unit), gum_uncertainty(factor * expanded));
}

Markup judged_limit(const JudgedFigure& figure, PressureUnit unit) {
  return with_unit(figure.limit, quantity_of(figure.criterion), unit);
}

Markup judged_mark(const ReportInput& input, const JudgedFigure& figure) {
  if (figure.verdict == Verdict::kReportOnly) return markup("– no verdict");
  if (input.judgement.not_judged) return markup("– not judged");
  return verdict_mark(figure.verdict, is_simulated(input));
}

Markup verdict_section(const ReportInput& input) {
  Markup out = section_start("verdicts", "Statement of conformity");
  if (input.judgement.figures.empty() && !input.judgement.not_judged) {
    out +=
        markup("<p>No tolerance limits were given: the figures are reported without a statement of conformity.</p>\n");
    out += instruments_warning(input);
    out += findings_in_brief(input.health);
    out += readings_in_brief(input);
    out += conditions_in_brief(input);
    return out;
  }
  out += overall_part(input);
  out += instruments_warning(input);
  out += findings_in_brief(input.health);
  out += readings_in_brief(input);
  out += conditions_in_brief(input);
  out += judged_runs_part(input);
  if (input.judgement.figures.empty()) return out;
  out += judged_runs(input).size() > 1 ? criteria_by_run(input) : criteria_of_one_run(input);
  out += markup("<p class=\"note\">{}: {}. The limits file has the SHA-256 {}.</p>\n",
                Text(input.judgement.not_judged ? "Figures of" : "Judged on"), Text(titles_judged(input)),
                code(input.judgement.limits_sha256));
  out += rules_in_words(input.judgement.figures);
  out += uncertainties_in_words(input);
  return out;
}

}  // namespace tactbench::analysis
