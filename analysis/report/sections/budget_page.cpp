// Page 6: checks, kinds of histories, budget, decision rule, signature, hashes.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

constexpr std::size_t kMostChecks = 10;  // listed; all are in the data

doc::Table kinds(const ReportInput& input) {
  doc::Table table{.id = "kinds",
                   .caption = "U of a reading by kind of history",
                   .columns = {{"kind of history"},
                               {fmt::format("median U, {}", input.unit.symbol()), true},
                               {"based on, or why it is not valid"}},
                   .dense = true};
  std::string not_measured;
  for (const ConditionUncertainty& kind : input.uncertainty->conditions) {
    const std::string& name = kind.name;
    if (kind.valid())
      table.rows.push_back({{Phrase(doc::StyledText{"✓ ", doc::TextStyle::kGood}, name),
                             doc::bare_pressure(kind.median_psi), kind.basis}});
    else if (kind.histories == 0)
      not_measured += (not_measured.empty() ? "" : "; ") + name;
    else
      table.rows.push_back(
          {{Phrase(doc::StyledText{"✗ ", doc::TextStyle::kBad}, name), "–", "not valid: " + kind.not_valid}});
  }
  if (!not_measured.empty())
    table.rows.push_back({{Phrase(doc::StyledText{"✗ ", doc::TextStyle::kBad}, "not measured"), "–", not_measured}});
  return table;
}

std::string degrees_text(double dof) {
  if (std::isnan(dof)) return "–";
  return dof > 1000.0 ? (std::isinf(dof) ? "∞" : "> 1000")
                      : doc::fixed_text(std::floor(dof), 0);  // cut: JCGM 100, G.4.1
}

doc::Table budget(const ReportInput& input, const LevelUncertainty& level) {
  const Budget& own = level.median;
  const PressureUnit unit = input.unit;
  std::vector<Contribution> rows = own.contributions;
  std::ranges::stable_sort(rows, std::greater<>(), &Contribution::u_psi);
  doc::Table table{
      .id = "budget",
      .caption = fmt::format("Budget of the median taxel ({}) at {}, {}",
                             doc::text_of(Phrase(doc::Taxel{own.taxel, input.health.columns}), unit),
                             doc::text_of(doc::both_units(level.pressure_psi), unit), direction_text(level.up)),
      .columns = {{"contribution"},
                  {"type"},
                  {"width", true},
                  {"distribution"},
                  {"divisor", true},
                  {fmt::format("u, {}", unit.symbol()), true},
                  {"ν", true},
                  {"share, %", true}},
      .dense = true,
      .keep = true};
  std::string small;  // below a thousandth of the variance
  for (const Contribution& row : rows) {
    const SourceText& text = text_of(row.source);
    const bool volts = std::string_view(text.unit) == "V";
    const double share = own.combined_psi > 0.0 ? std::pow(row.u_psi / own.combined_psi, 2) : 0.0;
    if (share < 0.0005) {
      small += (small.empty() ? "" : "; ") + std::string(text.name);
      continue;
    }
    table.rows.push_back({{text.name, std::string(1, text.type),
                           volts ? Phrase(doc::two_digits(1e3 * row.width), " mV")
                                 : Phrase(doc::two_digits(unit.of(row.width)), " ", unit.symbol()),
                           text.distribution, doc::number(row.divisor, row.divisor == std::floor(row.divisor) ? 0 : 2),
                           doc::two_digits(unit.of(row.u_psi)), degrees_text(row.dof), doc::percent_of(share, 1)}});
  }
  if (!small.empty()) table.rows.push_back({{"each below 0.1 %", small}});
  table.rows.push_back(
      {{"combined", "", "", "", "", doc::two_digits(unit.of(own.combined_psi)), degrees_text(own.dof), "100"},
       false,
       true});
  table.rows.push_back({{fmt::format("expanded, k = {}, about 95 %", doc::fixed_text(own.factor, 2)), "", "", "", "",
                         doc::two_digits(unit.of(own.expanded_psi)),
                         Phrase("of a reading whose known error, ",
                                doc::bare_pressure_with_u(own.error_psi, own.expanded_psi), ", is subtracted")},
                        false,
                        true});
  return table;
}

Document decision_rule(const Judgement& judgement) {
  Document out;
  out.add(doc::Heading{3, "Decision rule", {}});
  const std::vector<DecisionRule> rules = rules_of(judgement);
  if (rules.empty()) out.add(doc::Paragraph{{"none: nothing was judged"}});
  for (const DecisionRule rule : rules)
    out.add(doc::Paragraph{{title_case(rule_text(rule)) + "."}, doc::Paragraph::kNote});
  return out;
}

doc::Table requirements(const ReportInput& input) {
  doc::Table table{.id = "requirements",
                   .caption = "Checks: those not passed, and for each kind the one closest to its limit",
                   .columns = {{"check"}, {"run"}, {"value", true}, {"limit", true}, {"verdict"}},
                   .dense = true};
  std::vector<JudgedFigure> rows = input.judgement.figures;
  const auto rank = [](const JudgedFigure& row) { return std::pair(row.verdict, row.use_of_limit()); };
  std::ranges::stable_sort(rows, std::greater<>(), rank);
  std::vector<Criterion> named;
  for (const JudgedFigure& row : rows) {
    const bool first = std::ranges::find(named, row.criterion) == named.end();
    if (!first && (passes(row.verdict) || table.rows.size() >= kMostChecks)) continue;
    if (first) named.push_back(row.criterion);
    table.rows.push_back(
        {{requirement_name(row, input.unit), title_of_judged(input, row.run),
          figure_phrase(row.criterion, row.value, row.u.expanded), figure_phrase(row.criterion, row.limit),
          input.judgement.not_judged ? Phrase("not judged") : Phrase(row.verdict)}});
  }
  return table;
}

Document signature(const PageData& data) {
  const Issue& issue = data.issue;
  const std::string& function = data.input.laboratory.signer_function;
  Document out;
  out.add(doc::Heading{3, "Authorised by", {}});
  out.add(doc::Paragraph{issue.draft()
                             ? Phrase("\n______________________    ______________\n",
                                      doc::quiet("name, function; date. Draft: not signed."))
                             : Phrase(doc::strong(issue.authorised_by), ", ", function.empty() ? "" : function + ", ",
                                      moment_text(issue.authorised_utc))});
  out.add(doc::Paragraph{{"Date of issue: ", doc::stated(issue.issued), ". Replaces ",
                          issue.replaces.empty() ? "no earlier report of this run."
                                                 : issue.replaces + ": " + doc::stated(issue.reason).text + "."}});
  return out;
}

doc::Table integrity(const PageData& data) {
  const ReportInput& input = data.input;
  const auto short_hash = [](const std::string& hash) { return doc::code_text(hash.substr(0, 16)); };
  doc::Table table =
      doc::pairs("Data and integrity", {{"all data", doc::code_text("tactbench report RUN --format json")},
                                        {"check a copy", doc::code_text("tactbench report verify FILE")},
                                        {"run, SHA-256", short_hash(input.run.content_sha256)},
                                        {"models", short_hash(input.fit.taxels.empty() ? "" : model_sha256(input.fit))},
                                        {"limits file", short_hash(input.judgement.limits_sha256)},
                                        {"laboratory file", short_hash(input.laboratory.sha256)},
                                        {"program", input.program_version}});
  table.dense = true;
  return table;
}

}  // namespace

Document budget_page(const PageData& data) {
  const ReportInput& input = data.input;
  Document out, left, right;
  out.add(doc::Heading{2, "Checks, uncertainty, decision rule", "why"});
  if (!input.judgement.figures.empty()) out.add(requirements(input));
  if (input.uncertainty && !input.uncertainty->conditions.empty()) out.add(kinds(input));
  if (input.uncertainty && !input.uncertainty->levels.empty())
    out.add(budget(input, input.uncertainty->levels[input.uncertainty->chosen]));
  out.add(decision_rule(input.judgement));
  left.add(signature(data));
  right.add(integrity(data));
  out.add(doc::SideBySide{{left, right}, {1, 1}});
  return out;
}

}  // namespace tactbench::analysis
