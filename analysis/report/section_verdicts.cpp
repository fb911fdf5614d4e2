#include <algorithm>

#include "analysis/report/page.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

// A share of full scale reads better in per cent; a pressure carries kilopascals.
Markup with_unit(double value, const std::string& unit) {
  if (unit == "psi") return markup("{}", html::psi(value, 3));
  if (unit == "FS" || unit == "fs" || unit == "share of FS") return markup("{} % FS", html::percent(value, 2));
  return markup("{} {}", html::significant(value, 5), Text(unit));
}

// The runs judged, by their names in this report: a verdict on the run that the models were made from says less.
std::string judged_runs(const ReportInput& input) {
  std::vector<std::string> names;
  for (const db::VerdictRecord& verdict : input.verdicts) {
    std::string name = verdict.run == input.run.run ? "own run (fit)" : "a run that is not part of this report";
    for (const HeldOut& held_out : input.held_out) {
      if (held_out.run.run == verdict.run && verdict.run != input.run.run) name = held_out.title;
    }
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, "; "));
}

Markup rule_in_words(const std::string& rule) {
  if (rule != "simple") return markup("Decision rule: {}.", stated(rule));
  return markup(
      "Decision rule “simple” (ILAC-G8): pass when the value is at most the limit. The uncertainty is not taken into "
      "account; for a value at the limit the risk of a false acceptance is up to 50 %.");
}

// Each rule used, once.
Markup rules_in_words(const std::vector<db::VerdictRecord>& verdicts) {
  std::vector<std::string> rules;
  Markup out;
  for (const db::VerdictRecord& verdict : verdicts) {
    if (std::find(rules.begin(), rules.end(), verdict.rule) != rules.end()) continue;
    rules.push_back(verdict.rule);
    out += rule_in_words(verdict.rule);
    out += markup(" ");
  }
  return out;
}

}  // namespace

Markup verdict_section(const ReportInput& input) {
  const bool simulated = is_simulated(input);
  Markup out = section_start("verdicts", "Verdicts");
  if (input.verdicts.empty()) {
    out += markup("<p>No limits were given: the figures are reported without a verdict.</p>\n");
    return out;
  }
  const std::string overall = overall_verdict(input.verdicts);
  out += markup("<p>All criteria together: {}</p>\n", verdict_mark(overall, simulated));
  out += markup(
      "<table class=\"verdicts\"><caption>Criteria</caption><thead><tr><th scope=\"col\">criterion</th><th "
      "scope=\"col\">scope</th>"
      "<th scope=\"col\" class=\"n\">value</th><th scope=\"col\" class=\"n\">limit</th><th "
      "scope=\"col\">verdict</th></tr></thead><tbody>\n");
  for (const db::VerdictRecord& verdict : input.verdicts) {
    std::string criterion = verdict.criterion;
    for (char& c : criterion) c = c == '_' ? ' ' : c;
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}<td>{}</td></tr>\n", stated(criterion),
                  stated(verdict.scope), number_cell(with_unit(verdict.value, verdict.unit)),
                  number_cell(with_unit(verdict.limit, verdict.unit)), verdict_mark(verdict.verdict, simulated));
  }
  out += markup("</tbody></table>\n<p class=\"note\">Judged on: {}. {}The limits file has the SHA-256 {}.</p>\n",
                Text(judged_runs(input)), rules_in_words(input.verdicts), code(input.verdicts.front().limits_sha256));
  return out;
}

}  // namespace tactbench::analysis
