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
Markup with_unit(double value, const std::string& unit, PressureUnit shown, double expanded = 0.0) {
  if (!std::isfinite(value)) return markup("not available");
  const bool known = std::isfinite(expanded) && expanded > 0.0;
  if (unit == "psi")
    return known ? gum_pressure_value(value, expanded, shown) : markup("{}", html::pressure(value, shown, 3));
  if (unit == "FS" || unit == "fs" || unit == "share of FS")
    return markup("{}\u00A0%\u00A0FS", html::percent(value, known ? gum_decimals(100.0 * expanded) : 2));
  return markup("{} {}", html::significant(value, 5), Text(unit == "taxels" && value == 1.0 ? "taxel" : unit));
}

std::string titles_judged(const ReportInput& input) {
  std::vector<std::string> names;
  for (const JudgedRun& run : judged_runs(input)) names.push_back(run.title);
  return fmt::format("{}", fmt::join(names, "; "));
}

// Each rule used, once.
Markup rules_in_words(const std::vector<db::VerdictRecord>& verdicts) {
  std::vector<std::string> rules;
  Markup out;
  for (const db::VerdictRecord& verdict : verdicts) {
    if (std::find(rules.begin(), rules.end(), verdict.rule) != rules.end()) continue;
    rules.push_back(verdict.rule);
    out += markup("<p>Decision rule {}.</p>\n", stated(rule_in_words(verdict.rule)));
  }
  return out;
}

Markup uncertainty_cell(const JudgedUncertainty* known, const std::string& unit, PressureUnit shown) {
  if (known == nullptr || std::isnan(known->expanded)) return number_cell(Text("not known"));
  if (known->expanded == 0.0) return number_cell(Text("0"));
  if (unit == "psi") return number_cell(gum_pressure(known->expanded, shown));
  // As the value beside it: shares in per cent.
  if (unit == "FS") return number_cell(markup("{}\u00A0%\u00A0FS", gum_uncertainty(100.0 * known->expanded)));
  return number_cell(markup("{}\u00A0{}", gum_uncertainty(known->expanded), Text(unit)));
}

// How U of each criterion is formed, or why it is not known; once a criterion.
Markup uncertainties_in_words(const ReportInput& input) {
  Markup rows;
  std::vector<std::string> stated_already;
  for (const db::VerdictRecord& verdict : input.verdicts) {
    const JudgedUncertainty* const known = uncertainty_of(input, verdict);
    if (known == nullptr || std::ranges::find(stated_already, verdict.criterion) != stated_already.end()) continue;
    stated_already.push_back(verdict.criterion);
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}{}</td></tr>\n", Text(criterion_in_words(verdict.criterion)),
                   Text(known->missing.empty() ? "" : "not known: "),
                   Text(input.unit.both_in_text(known->missing.empty() ? known->basis : known->missing)));
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
  for (const db::VerdictRecord& verdict : input.verdicts) {
    const JudgedUncertainty* const known = uncertainty_of(input, verdict);
    out +=
        markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}{}<td>{}</td><td>{}</td></tr>\n",
               stated(criterion_in_words(verdict.criterion)), stated(scope_in_both_units(verdict.scope, input.unit)),
               number_cell(judged_value(known, verdict, input.unit)), uncertainty_cell(known, verdict.unit, input.unit),
               number_cell(judged_limit(verdict, input.unit)), stated(verdict.rule), judged_mark(input, verdict));
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

const JudgedUncertainty* uncertainty_of(const ReportInput& input, const db::VerdictRecord& verdict) {
  return find_uncertainty(input.judged, verdict.criterion, verdict.scope, verdict.run);
}

Markup judged_value(const JudgedUncertainty* known, const db::VerdictRecord& verdict, PressureUnit unit) {
  return with_unit(verdict.value, verdict.unit, unit, known == nullptr ? 0.0 : known->expanded);
}

Markup judged_with_uncertainty(const JudgedUncertainty* known, const db::VerdictRecord& verdict, PressureUnit unit) {
  const bool shown = known != nullptr && known->expanded > 0.0 && std::isfinite(verdict.value);  // a NaN is not
  if (!shown) return judged_value(known, verdict, unit);
  if (verdict.unit == "psi") return gum_pressure_stated(verdict.value, known->expanded, unit);
  const double factor = verdict.unit == "FS" ? 100.0 : 1.0;
  return markup("{} ± {}", judged_value(known, verdict, unit), gum_uncertainty(factor * known->expanded));
}

Markup judged_limit(const db::VerdictRecord& verdict, PressureUnit unit) {
  return with_unit(verdict.limit, verdict.unit, unit);
}

Markup judged_mark(const ReportInput& input, const db::VerdictRecord& verdict) {
  if (verdict_in(verdict) == Verdict::kReportOnly) return markup("– no verdict");
  if (!input.judgement.not_judged.empty()) return markup("– not judged");
  return verdict_mark(verdict_in(verdict), is_simulated(input));
}

Markup verdict_section(const ReportInput& input) {
  Markup out = section_start("verdicts", "Statement of conformity");
  if (input.verdicts.empty() && input.judgement.not_judged.empty()) {
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
  if (input.verdicts.empty()) return out;
  out += judged_runs(input).size() > 1 ? criteria_by_run(input) : criteria_of_one_run(input);
  out += markup("<p class=\"note\">{}: {}. The limits file has the SHA-256 {}.</p>\n",
                Text(input.judgement.not_judged.empty() ? "Judged on" : "Figures of"), Text(titles_judged(input)),
                code(input.verdicts.front().limits_sha256));
  out += rules_in_words(input.verdicts);
  out += uncertainties_in_words(input);
  return out;
}

}  // namespace tactbench::analysis
