#include <algorithm>
#include <cmath>

#include "analysis/report/gum_numbers.h"
#include "analysis/report/page.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

// A share of full scale reads better in per cent; a pressure carries kilopascals.
// Beside a known U the value has its decimal place (gum_numbers.h).
Markup with_unit(double value, const std::string& unit, double expanded = 0.0) {
  if (!std::isfinite(value)) return markup("not available");
  const bool known = std::isfinite(expanded) && expanded > 0.0;
  if (unit == "psi") return markup("{}", html::psi(value, known ? gum_decimals(expanded) : 3));
  if (unit == "FS" || unit == "fs" || unit == "share of FS")
    return markup("{}\u00A0%\u00A0FS", html::percent(value, known ? gum_decimals(100.0 * expanded) : 2));
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

const JudgedUncertainty* uncertainty_of(const ReportInput& input, const db::VerdictRecord& verdict) {
  return find_uncertainty(input.judged, verdict.criterion, verdict.scope);
}

Markup uncertainty_cell(const JudgedUncertainty* known, const std::string& unit) {
  if (known == nullptr || std::isnan(known->expanded)) return number_cell(Text("not known"));
  if (known->expanded == 0.0) return number_cell(Text("0"));
  // As the value beside it: shares in per cent.
  if (unit == "FS") return number_cell(markup("{}\u00A0%\u00A0FS", gum_uncertainty(100.0 * known->expanded)));
  return number_cell(markup("{}\u00A0{}", gum_uncertainty(known->expanded), Text(unit)));
}

std::string words_of(std::string criterion) {
  std::replace(criterion.begin(), criterion.end(), '_', ' ');
  return criterion;
}

// How U of each criterion is formed, or why it is not known; once a criterion.
Markup uncertainties_in_words(const ReportInput& input) {
  Markup rows;
  std::vector<std::string> told;
  for (const db::VerdictRecord& verdict : input.verdicts) {
    const JudgedUncertainty* const known = uncertainty_of(input, verdict);
    if (known == nullptr || std::find(told.begin(), told.end(), verdict.criterion) != told.end()) continue;
    told.push_back(verdict.criterion);
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}{}</td></tr>\n", Text(words_of(verdict.criterion)),
                   Text(known->missing.empty() ? "" : "not known: "),
                   Text(known->missing.empty() ? known->basis : known->missing));
  }
  if (rows.value.empty()) return rows;
  return markup(
      "<table class=\"pairs\"><caption>How U of each judged figure is formed</caption><tbody>\n{}</tbody></table>\n"
      "<p class=\"note\">U is that of the figure, a mean or a scatter over taxels, frames and levels, with k for 95.45 "
      "% "
      "(JCGM 100, G.3, G.4); it is not that of one taxel’s reading. A guard band of U tests one limit on one side: the "
      "risk beyond it is half of 4.55 %. What is not assessed for a reading (section Uncertainty) is not in it "
      "either.</p>\n",
      rows);
}

Markup shown_mark(const std::string& verdict, bool simulated) {
  if (verdict == "report only") return markup("– no verdict");
  return verdict_mark(verdict, simulated);
}

bool all_report_only(const std::vector<db::VerdictRecord>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(),
                     [](const db::VerdictRecord& verdict) { return verdict.verdict == "report only"; });
}

// What the criteria alone would hide: a pass is signed with these in view.
Markup not_well(const Health& health) {
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
      "href=\"#health\">Sensor health</a>. No criterion judges noise of a taxel or swapped lines.</p>\n",
      Text(fmt::format("{}", fmt::join(words, "; "))));
}

}  // namespace

Markup verdict_section(const ReportInput& input) {
  const bool simulated = is_simulated(input);
  Markup out = section_start("verdicts", "Verdicts");
  if (input.verdicts.empty()) {
    out += markup("<p>No limits were given: the figures are reported without a verdict.</p>\n");
    out += not_well(input.health);
    return out;
  }
  if (all_report_only(input.verdicts)) {
    out += markup("<p>Conformity is not stated: the limits file asks for a report only.</p>\n");
  } else {
    out += markup("<p>All criteria together: {}</p>\n", verdict_mark(overall_verdict(input.verdicts), simulated));
  }
  out += not_well(input.health);
  out += markup(
      "<table class=\"verdicts\"><caption>Criteria</caption><thead><tr><th scope=\"col\">criterion</th><th "
      "scope=\"col\">scope</th>"
      "<th scope=\"col\" class=\"n\">value</th><th scope=\"col\" class=\"n\">U</th><th scope=\"col\" "
      "class=\"n\">limit</th><th scope=\"col\">rule</th><th scope=\"col\">verdict</th></tr></thead><tbody>\n");
  for (const db::VerdictRecord& verdict : input.verdicts) {
    const JudgedUncertainty* const known = uncertainty_of(input, verdict);
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}{}<td>{}</td><td>{}</td></tr>\n",
                  stated(words_of(verdict.criterion)), stated(verdict.scope),
                  number_cell(with_unit(verdict.value, verdict.unit, known == nullptr ? 0.0 : known->expanded)),
                  uncertainty_cell(known, verdict.unit), number_cell(with_unit(verdict.limit, verdict.unit)),
                  stated(verdict.rule), shown_mark(verdict.verdict, simulated));
  }
  out += markup("</tbody></table>\n<p class=\"note\">Judged on: {}. The limits file has the SHA-256 {}.</p>\n",
                Text(judged_runs(input)), code(input.verdicts.front().limits_sha256));
  out += rules_in_words(input.verdicts);
  out += uncertainties_in_words(input);
  return out;
}

}  // namespace tactbench::analysis
