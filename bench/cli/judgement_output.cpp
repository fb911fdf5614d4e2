#include "bench/cli/judgement_output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/counted.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/document/document.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace doc = analysis::doc;
using analysis::JudgedFigure;
using analysis::Judgement;
using analysis::PressureUnit;
using analysis::Verdict;

namespace {

doc::Phrase measured(const JudgedFigure& figure) {
  return analysis::figure_phrase(figure.criterion, figure.value, figure.u.expanded);
}

std::string display_text(const JudgedFigure& figure, PressureUnit unit) {
  std::string why;
  if (figure.verdict == Verdict::kConditionalPass)
    why = ", within U below the limit";
  else if (figure.verdict == Verdict::kConditionalFail)
    why = ", within U above the limit";
  else if (figure.verdict == Verdict::kInconclusive && std::isfinite(figure.value) && std::isnan(figure.u.expanded))
    why = ", U not known";
  const std::string limit = figure_text(figure.criterion, figure.limit, unit);  // in the value's unit
  return fmt::format("{}{} {}, limit {}, run {}{}", requirement_name(figure, unit),
                     figure.scope.kind == analysis::Scope::Kind::kArray ? "" : ":",
                     doc::text_of(measured(figure), unit), limit.substr(0, limit.find(' ')), figure.run, why);
}

doc::Table table_of(const std::vector<const JudgedFigure*>& figures, PressureUnit unit) {
  doc::Table table{
      .columns = {{"run", true}, {.title = "check", .cut = true}, {"value", true}, {"limit", true}, {"verdict"}}};
  for (const JudgedFigure* const figure : figures)
    table.rows.push_back({{std::to_string(figure->run), requirement_name(*figure, unit), measured(*figure),
                           figure_text(figure->criterion, figure->limit, unit), figure->verdict}});
  return table;
}

// Whether the figures decide the verdict: false if a stored verdict is worse.
bool decided_here(const Judgement& judgement) { return judgement.overall == worst_of(judgement.figures); }

// Figures that do not pass, the worst first.
std::vector<const JudgedFigure*> not_passed(const Judgement& judgement) {
  std::vector<const JudgedFigure*> figures;
  for (std::size_t i = 0; i < judgement.figures.size(); ++i)
    if (judgement.figures[i].verdict > Verdict::kPass) figures.push_back(&judgement.figures[i]);
  std::ranges::stable_sort(figures, [](const JudgedFigure* a, const JudgedFigure* b) {
    return a->verdict != b->verdict ? a->verdict > b->verdict : a->use_of_limit() > b->use_of_limit();
  });
  return figures;
}

// "set-points as fitted (runs 2, 4), random reversals (run 3)".
std::string trajectories(const Judgement& judgement) {
  std::map<analysis::Trajectory, std::vector<std::int64_t>> runs;
  for (const analysis::JudgedRun& run : judgement.runs)
    if (run.trajectory.run != 0) runs[run.trajectory.trajectory].push_back(run.run);  // a store does not keep it
  std::vector<std::string> parts;
  for (const auto& [trajectory, of] : runs)
    parts.push_back(
        fmt::format("{} ({} {})", to_string(trajectory), of.size() == 1 ? "run" : "runs", fmt::join(of, ", ")));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_conditions(doc::Document& out, const Judgement& judgement, PressureUnit unit, bool all) {
  const auto add = [&](const std::string& text) { out.add(doc::Paragraph{{text}}); };
  if (states_conformity(judgement.overall) && !judgement.runs.empty()) {
    if (const std::string known = trajectories(judgement); !all && !known.empty()) add("errors are valid for " + known);
    for (const analysis::JudgedRun& run : judgement.runs)
      if (all && run.trajectory.run != 0)
        add(fmt::format("errors of run {} are valid for {}", run.run, analysis::display_text(run.trajectory)));
    if (const std::vector<std::string> open = kinds_left_open(judgement); !open.empty())
      add(fmt::format("the error of a reading is not known for: {}", fmt::join(open, "; ")));
    if (const std::string missing = not_assessed_text(judgement); !missing.empty()) add("not assessed: " + missing);
  }
  for (const JudgedFigure& figure : judgement.stored_worse)
    add(fmt::format("note: a stored verdict on these models is worse: {}, {}", to_string(figure.verdict),
                    display_text(figure, unit)));
  for (const analysis::Remark& remark : judgement.remarks) add("note: " + analysis::display_text(remark, unit));
}

}  // namespace

doc::Table figures_table(const std::vector<NamedEvaluation>& evaluations, const Judgement& judgement,
                         PressureUnit unit) {
  doc::Table table{.columns = {{"run", true},
                               {.title = "data", .cut = true},
                               {fmt::format("mean error\n{}", unit.symbol()), true},
                               {fmt::format("worst taxel\n{}", unit.symbol()), true},
                               {"hysteresis\n% FS", true},
                               {"corrected\n% FS", true}}};
  if (!judgement.runs.empty()) table.columns.push_back({"verdict"});
  for (const NamedEvaluation& named : evaluations) {
    const analysis::Evaluation& e = named.evaluation;
    const bool own = &named == &evaluations.front();
    doc::Row& row = table.rows.emplace_back();
    row.cells = {std::to_string(e.run),
                 own                                        ? "models' own"
                 : named.title.starts_with("held-out run ") ? "held out"
                                                            : named.title,
                 doc::bare_pressure(e.mean_error_psi, 2),
                 doc::bare_pressure(e.worst_taxel_mean_error_psi, 2),
                 doc::percent_of(e.raw_distance, 2),
                 doc::percent_of(e.comp_distance_of_mean, 2)};
    const auto judged = std::ranges::find(judgement.runs, e.run, &analysis::JudgedRun::run);
    if (judged != judgement.runs.end()) row.cells.emplace_back(judged->verdict);
  }
  return table;
}

std::string verdict_banner(const Judgement& judgement) {
  if (!states_conformity(judgement.overall)) return {};
  const ExitCode code = exit_code_of(judgement.overall);
  return code == ExitCode::kPass ? "PASS" : code == ExitCode::kCriterionFailed ? "FAIL" : "INCONCLUSIVE";
}

std::string headline(const Judgement& judgement, const std::string& origin, PressureUnit unit) {
  const std::vector<JudgedFigure>& figures = judgement.figures;
  const std::string simulated = origin == "simulated" ? " (simulated)" : "", word = verdict_banner(judgement);
  if (word.empty())
    return fmt::format("no verdict{}: {}", simulated,
                       figures.empty() ? "no limits were applied" : "the limits file requests figures only");
  std::string text = word + simulated;
  if (judgement.not_judged) return text + ": not judged: " + analysis::display_text(*judgement.not_judged, unit);
  text += condition_text(judgement, unit);
  const auto met = std::ranges::count_if(figures, [](const JudgedFigure& own) { return passes(own.verdict); });
  const std::string checks = analysis::counted(figures.size(), "check");
  if (!decided_here(judgement))
    return fmt::format("{}: because of a stored verdict; none of the {} here fails", text, checks);
  if (!judgement.deciding) return text;
  const std::string decided = display_text(figures[*judgement.deciding], unit);
  if (judgement.overall == Verdict::kPass)
    return fmt::format("{}: all {} pass; closest to its limit: {}", text, checks, decided);
  return fmt::format("{}: {}; {} of {} pass", text, decided, met, checks);
}

doc::Document judgement_document(const Judgement& judgement, const std::string& origin, PressureUnit unit, bool all) {
  constexpr std::size_t kRows = 4;
  doc::Document out;
  out.add(doc::Paragraph{{headline(judgement, origin, unit)}});
  std::vector<const JudgedFigure*> shown;
  if (all) {
    for (const JudgedFigure& figure : judgement.figures) shown.push_back(&figure);
  } else if (states_conformity(judgement.overall) && !judgement.not_judged) {
    shown = not_passed(judgement);
  }
  const std::size_t others = shown.size();
  if (!all) shown.resize(std::min(others, kRows));
  if (!all && judgement.closest_pass && judgement.overall != Verdict::kPass)
    shown.push_back(&judgement.figures[*judgement.closest_pass]);
  if (!shown.empty()) out.add(table_of(shown, unit));
  if (!all && others > kRows)
    out.add(doc::Paragraph{{fmt::format("and {} more that do not pass outright (--all)", others - kRows)}});
  if (all) {
    std::vector<std::string> rules;
    for (const analysis::DecisionRule rule : rules_of(judgement)) rules.emplace_back(to_string(rule));
    if (!rules.empty()) out.add(doc::Paragraph{{fmt::format("decision rule (ILAC-G8): {}", fmt::join(rules, ", "))}});
  }
  add_conditions(out, judgement, unit, all);
  return out;
}

nlohmann::ordered_json judgement_json(const Judgement& judgement, const std::string& origin) {
  nlohmann::ordered_json json = {{"shown", judgement.overall ? shown_verdict(*judgement.overall, origin) : ""}};
  json.update(analysis::judgement_json(judgement));
  return json;
}

}  // namespace tactbench::bench
