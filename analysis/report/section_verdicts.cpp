#include "analysis/report/page.h"

namespace tactbench::analysis {

using html::fixed;
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

Markup rule_in_words(const std::string& rule) {
  if (rule != "simple") return markup("Decision rule: {}.", stated(rule));
  return markup(
      "Decision rule “simple” (ILAC-G8): pass when the value is at most the limit. The uncertainty is not taken into "
      "account; for a value at the limit the risk of a false acceptance is up to 50 %.");
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
      "<table><caption>Criteria</caption><thead><tr><th scope=\"col\">criterion</th><th scope=\"col\">scope</th>"
      "<th scope=\"col\" class=\"n\">value</th><th scope=\"col\" class=\"n\">limit</th><th scope=\"col\">rule</th>"
      "<th scope=\"col\">verdict</th></tr></thead><tbody>\n");
  for (const db::VerdictRecord& verdict : input.verdicts) {
    std::string criterion = verdict.criterion;
    for (char& c : criterion) c = c == '_' ? ' ' : c;
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}<td>{}</td><td>{}</td></tr>\n", stated(criterion),
                  stated(verdict.scope), number_cell(with_unit(verdict.value, verdict.unit)),
                  number_cell(with_unit(verdict.limit, verdict.unit)), stated(verdict.rule),
                  verdict_mark(verdict.verdict, simulated));
  }
  out += markup("</tbody></table>\n<p class=\"note\">{} The limits file has the SHA-256 {}.</p>\n",
                rule_in_words(input.verdicts.front().rule), code(input.verdicts.front().limits_sha256));
  return out;
}

}  // namespace tactbench::analysis
