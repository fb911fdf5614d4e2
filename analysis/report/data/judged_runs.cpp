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

std::vector<std::int64_t> numbers_of(std::span<const db::VerdictRecord> verdicts) {
  std::vector<std::int64_t> numbers;
  for (const RunVerdict& run : verdicts_by_run(verdicts)) numbers.push_back(run.run);
  return numbers;
}

// The titles of the deciding runs; empty when all runs have the same verdict.
std::string decided_by(const ReportInput& input) {
  const std::vector<std::int64_t> deciding = deciding_runs(input.verdicts);
  if (deciding.size() == numbers_of(input.verdicts).size()) return {};
  std::vector<std::string> titles;
  for (const std::int64_t run : deciding) titles.push_back(title_of_judged(input, run));
  return fmt::format(", decided by {}", fmt::join(titles, " and "));
}

const JudgedTrajectory* trajectory_of(const JudgementNotes& notes, std::int64_t run) {
  const auto found = std::ranges::find(notes.trajectories, run, &JudgedTrajectory::run);
  return found == notes.trajectories.end() ? nullptr : &*found;
}

Markup runs_table(const ReportInput& input, const std::vector<JudgedRun>& runs) {
  const bool simulated = is_simulated(input), stated_words = states_conformity(overall_verdict(input.verdicts));
  Markup out = markup(
      "<table><caption>Runs judged</caption><thead><tr><th scope=\"col\">run</th><th scope=\"col\" "
      "class=\"n\">number</th><th scope=\"col\">started (UTC)</th><th scope=\"col\">trajectory</th><th "
      "scope=\"col\">conformity</th></tr></thead><tbody>\n");
  for (const JudgedRun& judged : runs) {
    const bool there = judged.run != nullptr;
    const JudgedTrajectory* const trajectory = trajectory_of(input.judgement, judged.number);
    out += markup("<tr><th scope=\"row\">{}</th>{}<td>{}</td><td>{}</td><td>{}</td></tr>\n", Text(judged.title),
                  number_cell(there ? Text(std::to_string(judged.run->run)) : Text("–")),
                  there ? moment(judged.run->started_utc) : Text("–"),
                  Text(trajectory == nullptr ? std::string("–") : in_words(*trajectory)),
                  stated_words ? verdict_mark(judged.verdict, simulated) : markup("– no verdict"));
  }
  out += markup("</tbody></table>\n");
  return out;
}

// For what the errors hold, and what was not assessed.
Markup conditions_part(const JudgementNotes& notes) {
  if (notes.trajectories.empty()) return {};
  std::vector<std::string> held;
  for (const JudgedTrajectory& judged : notes.trajectories)
    if (const std::string word = to_string(judged.trajectory); std::ranges::find(held, word) == held.end())
      held.push_back(word);
  Markup out = markup("<p>The errors hold for the trajectories judged ({}), and for no other.</p>\n",
                      Text(fmt::format("{}", fmt::join(held, ", "))));
  if (notes.not_assessed.empty()) return out;
  Markup rows;
  for (const UnassessedSource& missing : notes.not_assessed)
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", Text(missing.source), Text(missing.why));
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
  const std::vector<db::VerdictRecord>& stored = input.judgement.stored_worse;
  if (stored.empty()) return {};
  std::vector<std::string> runs, limits;
  for (const RunVerdict& run : verdicts_by_run(stored))
    runs.push_back(fmt::format("{}: {}", title_of_judged(input, run.run), to_string(run.verdict)));
  for (const db::VerdictRecord& verdict : stored)
    if (std::ranges::find(limits, verdict.limits_sha256) == limits.end()) limits.push_back(verdict.limits_sha256);
  return markup(
      "<p>Stored verdict on these models, worse than the one above: {} ({}), by the limits with the SHA-256 {}.</p>\n",
      verdict_mark(*overall_verdict(stored), is_simulated(input)), Text(fmt::format("{}", fmt::join(runs, "; "))),
      code(fmt::format("{}", fmt::join(limits, ", "))));
}

// Verdicts of one criterion and scope, in the order of `runs`; null where a run has none.
std::vector<const db::VerdictRecord*> across(const ReportInput& input, std::span<const JudgedRun> runs,
                                             const db::VerdictRecord& like) {
  std::vector<const db::VerdictRecord*> row;
  for (const JudgedRun& run : runs) {
    const auto found = std::ranges::find_if(input.verdicts, [&](const db::VerdictRecord& v) {
      return v.run == run.number && v.criterion == like.criterion && v.scope == like.scope;
    });
    row.push_back(found == input.verdicts.end() ? nullptr : &*found);
  }
  return row;
}

Markup criteria_table(const ReportInput& input, std::span<const JudgedRun> runs) {
  Markup out = markup(
      "<table class=\"levels even\"><caption>Requirements: value ± U and conformity on each "
      "run</caption><thead><tr><th "
      "scope=\"col\">requirement</th><th scope=\"col\">scope</th><th scope=\"col\" class=\"n\">tolerance limit</th>");
  for (const JudgedRun& run : runs) out += markup("<th scope=\"col\">{}</th>", Text(run.title));
  out += markup("</tr></thead><tbody>\n");
  std::vector<std::pair<std::string, std::string>> written;
  for (const db::VerdictRecord& verdict : input.verdicts) {
    if (std::ranges::find(written, std::pair(verdict.criterion, verdict.scope)) != written.end()) continue;
    written.emplace_back(verdict.criterion, verdict.scope);
    out +=
        markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}", stated(criterion_in_words(verdict.criterion)),
               stated(scope_in_both_units(verdict.scope, input.unit)), number_cell(judged_limit(verdict, input.unit)));
    for (const db::VerdictRecord* own : across(input, runs, verdict)) {
      if (own == nullptr) {
        out += markup("<td>–</td>");
        continue;
      }
      out += markup("<td>{}<br/>{}</td>", judged_with_uncertainty(uncertainty_of(input, *own), *own, input.unit),
                    judged_mark(input, *own));
    }
    out += markup("</tr>\n");
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

std::optional<Verdict> final_verdict(std::span<const db::VerdictRecord> verdicts, const JudgementNotes& notes) {
  if (!notes.not_judged.empty()) return Verdict::kInconclusive;
  const auto failed = [](const db::VerdictRecord& row) { return verdict_in(row) == Verdict::kFail; };
  if (std::ranges::any_of(notes.stored_worse, failed)) return Verdict::kFail;
  return overall_verdict(verdicts);
}

std::string condition_in_words(Verdict overall, const JudgementNotes& notes) {
  if (overall == Verdict::kInconclusive && !notes.untraced.empty()) return ": " + notes.untraced;
  const bool passes = overall == Verdict::kPass || overall == Verdict::kConditionalPass;
  return passes && !notes.not_assessed.empty() ? ", under repeatability conditions only" : "";
}

std::string statement_in_words(Verdict overall, const JudgementNotes& notes) {
  return to_string(overall) + condition_in_words(overall, notes);
}

std::string not_assessed_in_words(const JudgementNotes& notes) {
  std::vector<std::string> sources;
  for (const UnassessedSource& missing : notes.not_assessed) sources.push_back(missing.source);
  return fmt::format("{}", fmt::join(sources, "; "));
}

std::string title_of_judged(const ReportInput& input, std::int64_t run) {
  if (run == input.run.run) {
    const bool others = std::ranges::any_of(input.verdicts, [&](const db::VerdictRecord& v) {
      return v.run == run && v.model_run != 0 && v.model_run != run;
    });
    return others ? "this run" : "own run (calibration data)";
  }
  const HeldOut* const held_out = held_out_of(input, run);
  return held_out == nullptr ? fmt::format("run {}, no part of this report", run) : held_out->title;
}

std::vector<JudgedRun> judged_runs(const ReportInput& input) {
  std::vector<JudgedRun> runs;
  for (const RunVerdict& own : verdicts_by_run(input.verdicts)) {
    const HeldOut* const held_out = held_out_of(input, own.run);
    runs.push_back({own.run, title_of_judged(input, own.run),
                    own.run == input.run.run ? &input.run : (held_out == nullptr ? nullptr : &held_out->run),
                    own.verdict});
  }
  return runs;
}

Markup overall_part(const ReportInput& input) {
  const JudgementNotes& notes = input.judgement;
  const std::optional<Verdict> overall = overall_verdict(input.verdicts);
  Markup out;
  if (!notes.not_judged.empty()) {
    out += markup("<p>All requirements together: {}, not judged: {}.</p>\n",
                  verdict_mark(Verdict::kInconclusive, is_simulated(input)), Text(notes.not_judged));
  } else if (!states_conformity(overall)) {
    out += markup("<p>Conformity is not stated: the limits file asks for a report only.</p>\n");
  } else {
    const std::string reason = reason_of_verdict(input);
    out += markup("<p>All requirements together: {}{}{}.</p>\n", verdict_mark(*overall, is_simulated(input)),
                  Text(input.unit.both_in_text(reason.empty() ? condition_in_words(*overall, notes) : ": " + reason)),
                  Text(decided_by(input)));
  }
  if (input.more.previous && !input.more.previous->doubt.empty()) out += warning(input.more.previous->doubt);
  out += stored_part(input);
  for (const std::string& remark : notes.remarks) out += warning(input.unit.both_in_text(remark));
  return out;
}

Markup judged_runs_part(const ReportInput& input) {
  if (!input.judgement.not_judged.empty()) return {};
  Markup out = runs_table(input, judged_runs(input));
  out += conditions_part(input.judgement);
  return out;
}

Markup criteria_by_run(const ReportInput& input) {
  const std::vector<JudgedRun> runs = judged_runs(input);
  Markup out;
  for (std::size_t first = 0; first < runs.size(); first += kJudgedRunsPerTable)
    out += criteria_table(input, std::span(runs).subspan(first, std::min(kJudgedRunsPerTable, runs.size() - first)));
  return out;
}

}  // namespace tactbench::analysis
