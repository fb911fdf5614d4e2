#include "analysis/report/data/judged_runs.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "analysis/report/data/traceability.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

constexpr std::size_t kJudgedRunsPerTable = 3;  // as many columns as A4 holds beside requirement, scope and limit

const HeldOut* held_out_of(const ReportInput& input, std::int64_t run) {
  if (run == input.run.run) return nullptr;
  const auto found =
      std::ranges::find_if(input.held_out, [&](const HeldOut& held_out) { return held_out.evaluation.run == run; });
  return found == input.held_out.end() ? nullptr : &*found;
}

// The titles of the deciding runs; empty when all runs have the same verdict.
std::string decided_by(const ReportInput& input) {
  const std::vector<std::int64_t>& deciding = input.judgement.decided_by;
  if (deciding.size() == input.judgement.runs.size()) return {};
  std::vector<std::string> titles;
  for (const std::int64_t run : deciding) titles.push_back(title_of_judged(input, run));
  return fmt::format(", decided by {}", fmt::join(titles, " and "));
}

Markup runs_table(const ReportInput& input, const std::vector<JudgedColumn>& runs) {
  const bool simulated = is_simulated(input), stated_words = states_conformity(input.judgement.overall);
  Markup out = markup(
      "<table><caption>Runs judged</caption><thead><tr><th scope=\"col\">run</th><th scope=\"col\" "
      "class=\"n\">number</th><th scope=\"col\">started (UTC)</th><th scope=\"col\">trajectory</th><th "
      "scope=\"col\">conformity</th></tr></thead><tbody>\n");
  for (const JudgedColumn& column : runs) {
    const bool there = column.run != nullptr;
    const JudgedRun* const judged = stated_words ? column.judged : nullptr;
    out += markup("<tr><th scope=\"row\">{}</th>{}<td>{}</td><td>{}</td><td>{}</td></tr>\n", Text(column.title),
                  number_cell(there ? Text(std::to_string(column.run->run)) : Text("–")),
                  there ? moment(column.run->started_utc) : Text("–"),
                  Text(judged == nullptr ? std::string("–") : in_words(judged->trajectory)),
                  judged != nullptr ? verdict_mark(judged->verdict, simulated) : markup("– no verdict"));
  }
  out += markup("</tbody></table>\n");
  return out;
}

// For what the errors hold, and what was not assessed.
Markup conditions_part(const Judgement& judgement) {
  if (!states_conformity(judgement.overall)) return {};
  std::vector<std::string> held;
  for (const JudgedRun& run : judgement.runs)
    if (const std::string word = to_string(run.trajectory.trajectory); std::ranges::find(held, word) == held.end())
      held.push_back(word);
  Markup out = markup("<p>The errors hold for the trajectories judged ({}), and for no other.</p>\n",
                      Text(fmt::format("{}", fmt::join(held, ", "))));
  if (judgement.not_assessed.empty()) return out;
  Markup rows;
  for (const Source source : judgement.not_assessed)
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", Text(to_string(source)),
                   Text(why_not_assessed(source)));
  out += markup(
      "<table class=\"pairs\"><caption>Not assessed: not covered by the statement of "
      "conformity</caption><tbody>\n{}</tbody></table>\n",
      rows);
  return out;
}

Markup warning(const std::string& words) {
  return markup("<p class=\"fail\"><span class=\"sign\">✗</span> {}</p>\n", Text(words));
}

Markup stored_part(const ReportInput& input) {
  Judgement stored;
  stored.figures = input.judgement.stored_worse;
  if (stored.figures.empty()) return {};
  conclude(stored);
  std::vector<std::string> runs, limits;
  for (const JudgedRun& run : stored.runs)
    runs.push_back(fmt::format("{}: {}", title_of_judged(input, run.run), to_string(run.verdict)));
  for (const JudgedFigure& figure : stored.figures)
    if (std::ranges::find(limits, figure.limits_sha256) == limits.end()) limits.push_back(figure.limits_sha256);
  return markup(
      "<p>Stored verdict on these models, worse than the one above: {} ({}), by the limits with the SHA-256 {}.</p>\n",
      verdict_mark(*stored.overall, is_simulated(input)), Text(fmt::format("{}", fmt::join(runs, "; "))),
      code(fmt::format("{}", fmt::join(limits, ", "))));
}

// Figures of one criterion and scope, in the order of `runs`; null where a run has none.
std::vector<const JudgedFigure*> across(const ReportInput& input, std::span<const JudgedColumn> runs,
                                        const JudgedFigure& like) {
  std::vector<const JudgedFigure*> row;
  for (const JudgedColumn& run : runs) {
    const auto found = std::ranges::find_if(input.judgement.figures, [&](const JudgedFigure& own) {
      return own.run == run.number && own.criterion == like.criterion && own.scope == like.scope;
    });
    row.push_back(found == input.judgement.figures.end() ? nullptr : &*found);
  }
  return row;
}

Markup criteria_table(const ReportInput& input, std::span<const JudgedColumn> runs) {
  Markup out = markup(
      "<table class=\"levels even\"><caption>Requirements: value ± U and conformity on each "
      "run</caption><thead><tr><th "
      "scope=\"col\">requirement</th><th scope=\"col\">scope</th><th scope=\"col\" class=\"n\">tolerance limit</th>");
  for (const JudgedColumn& run : runs) out += markup("<th scope=\"col\">{}</th>", Text(run.title));
  out += markup("</tr></thead><tbody>\n");
  std::vector<std::pair<Criterion, Scope>> written;
  for (const JudgedFigure& figure : input.judgement.figures) {
    if (std::ranges::find(written, std::pair(figure.criterion, figure.scope)) != written.end()) continue;
    written.emplace_back(figure.criterion, figure.scope);
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}", stated(in_words(figure.criterion)),
                  stated(in_both_units(figure.scope, input.unit)), number_cell(judged_limit(figure, input.unit)));
    for (const JudgedFigure* own : across(input, runs, figure)) {
      if (own == nullptr) {
        out += markup("<td>–</td>");
        continue;
      }
      out += markup("<td>{}<br/>{}</td>", judged_with_uncertainty(*own, input.unit), judged_mark(input, *own));
    }
    out += markup("</tr>\n");
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

std::string title_of_judged(const ReportInput& input, std::int64_t run) {
  if (run == input.run.run) {
    const bool others = std::ranges::any_of(input.judgement.figures, [&](const JudgedFigure& v) {
      return v.run == run && v.model_run != 0 && v.model_run != run;
    });
    return others ? "this run" : "own run (calibration data)";
  }
  const HeldOut* const held_out = held_out_of(input, run);
  return held_out == nullptr ? fmt::format("run {}, no part of this report", run) : held_out->title;
}

std::vector<JudgedColumn> judged_runs(const ReportInput& input) {
  std::vector<JudgedColumn> runs;
  for (const JudgedFigure& figure : input.judgement.figures) {
    if (std::ranges::find(runs, figure.run, &JudgedColumn::number) != runs.end()) continue;
    const HeldOut* const held_out = held_out_of(input, figure.run);
    const auto judged = std::ranges::find(input.judgement.runs, figure.run, &JudgedRun::run);
    runs.push_back({figure.run, title_of_judged(input, figure.run),
                    figure.run == input.run.run ? &input.run : (held_out == nullptr ? nullptr : &held_out->run),
                    judged == input.judgement.runs.end() ? nullptr : &*judged});
  }
  return runs;
}

Markup overall_part(const ReportInput& input) {
  const Judgement& judgement = input.judgement;
  Markup out;
  if (judgement.not_judged) {
    out += markup("<p>All requirements together: {}, not judged: {}.</p>\n",
                  verdict_mark(Verdict::kInconclusive, is_simulated(input)),
                  Text(in_words(*judgement.not_judged, input.unit)));
  } else if (!states_conformity(judgement.overall)) {
    out += markup("<p>Conformity is not stated: the limits file asks for a report only.</p>\n");
  } else {
    const std::string reason = reason_of_verdict(input);
    out += markup("<p>All requirements together: {}{}{}.</p>\n", verdict_mark(*judgement.overall, is_simulated(input)),
                  Text(reason.empty() ? condition_in_words(judgement, input.unit) : ": " + reason),
                  Text(decided_by(input)));
  }
  if (input.more.previous && !input.more.previous->doubt.empty()) out += warning(input.more.previous->doubt);
  out += stored_part(input);
  for (const Remark& remark : judgement.remarks) out += warning(in_words(remark, input.unit));
  return out;
}

Markup judged_runs_part(const ReportInput& input) {
  if (input.judgement.not_judged) return {};
  Markup out = runs_table(input, judged_runs(input));
  out += conditions_part(input.judgement);
  return out;
}

Markup criteria_by_run(const ReportInput& input) {
  const std::vector<JudgedColumn> runs = judged_runs(input);
  Markup out;
  for (std::size_t first = 0; first < runs.size(); first += kJudgedRunsPerTable)
    out += criteria_table(input, std::span(runs).subspan(first, std::min(kJudgedRunsPerTable, runs.size() - first)));
  return out;
}

}  // namespace tactbench::analysis
