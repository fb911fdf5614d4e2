#include "bench/cli/judgement_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/documents/evaluation_json.h"
#include "analysis/report/report.h"
#include "analysis/statistics/conformity/overall_verdict.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

using analysis::Verdict;

namespace {

std::string numbers_text(const std::vector<std::int64_t>& runs) {
  return fmt::format("{} {}", runs.size() == 1 ? "run" : "runs", fmt::join(runs, ", "));
}

}  // namespace

std::string conditions_text(const analysis::JudgementNotes& notes) {
  std::string text;
  for (const analysis::JudgedTrajectory& judged : notes.trajectories)
    text += fmt::format("errors of run {} hold for {}\n", judged.run, analysis::in_words(judged));
  if (const std::string missing = analysis::not_assessed_in_words(notes); !missing.empty())
    text += fmt::format("not assessed: {}\n", missing);
  return text;
}

std::string judgement_text(const Judgement& judgement, const std::string& origin) {
  const analysis::JudgementNotes& notes = judgement.notes;
  const std::optional<Verdict> overall = analysis::overall_verdict(judgement.verdicts);
  std::string text;
  if (!notes.not_judged.empty()) {
    text = fmt::format("all requirements together: {}, not judged: {}\n", shown_verdict(Verdict::kInconclusive, origin),
                       notes.not_judged);
  } else if (analysis::states_conformity(overall)) {
    std::vector<std::int64_t> judged;
    for (const analysis::RunVerdict& run : analysis::verdicts_by_run(judgement.verdicts)) judged.push_back(run.run);
    std::ranges::sort(judged);
    const std::vector<std::int64_t> deciding = analysis::deciding_runs(judgement.verdicts);
    text = fmt::format("all requirements together: {}{}{}; judged on {}\n", shown_verdict(*overall, origin),
                       analysis::condition_in_words(*overall, notes),
                       deciding.size() < judged.size() ? ", decided by " + numbers_text(deciding) : "",
                       numbers_text(judged));
  }
  text += conditions_text(notes);
  if (!notes.stored_worse.empty()) {
    std::vector<std::int64_t> runs;
    for (const analysis::RunVerdict& run : analysis::verdicts_by_run(notes.stored_worse)) runs.push_back(run.run);
    text +=
        fmt::format("stored verdict on these models, worse: {} on {}, by other limits or of runs not included here\n",
                    shown_verdict(*analysis::overall_verdict(notes.stored_worse), origin), numbers_text(runs));
  }
  for (const std::string& remark : notes.remarks) text += fmt::format("note: {}\n", remark);
  return text;
}

nlohmann::ordered_json judgement_json(const Judgement& judgement, const std::string& origin) {
  const analysis::JudgementNotes& notes = judgement.notes;
  const std::optional<Verdict> overall =
      notes.not_judged.empty() ? analysis::overall_verdict(judgement.verdicts) : Verdict::kInconclusive;
  auto runs = nlohmann::ordered_json::array(), voids = nlohmann::ordered_json::array();
  for (const analysis::RunVerdict& run : analysis::verdicts_by_run(judgement.verdicts))
    runs.push_back({{"run", run.run}, {"verdict", to_string(run.verdict)}});
  for (const db::RunRecord& run : judgement.void_runs)
    voids.push_back({{"run", run.run}, {"reason", run.void_reason}, {"by", run.void_by}, {"utc", run.void_utc}});
  auto trajectories = nlohmann::ordered_json::array(), missing = nlohmann::ordered_json::array();
  for (const analysis::JudgedTrajectory& judged : notes.trajectories) {
    trajectories.push_back(analysis::trajectory_json(judged));
    trajectories.back()["run"] = judged.run;
  }
  for (const analysis::UnassessedSource& source : notes.not_assessed)
    missing.push_back({{"source", source.source}, {"why", source.why}});
  return {{"overall", analysis::verdict_word(overall)},
          {"shown", overall ? shown_verdict(*overall, origin) : ""},
          {"statement", overall ? analysis::statement_in_words(*overall, notes) : ""},
          {"trajectories", trajectories},
          {"not_assessed", missing},
          {"untraced", notes.untraced},
          {"not_judged", notes.not_judged},
          {"runs", runs},
          {"decided_by", analysis::deciding_runs(judgement.verdicts)},
          {"void_runs", voids},
          {"stored_worse", verdicts_json(notes.stored_worse, origin)},
          {"remarks", notes.remarks}};
}

std::optional<Verdict> verdict_of(const Judgement& judgement) {
  return analysis::final_verdict(judgement.verdicts, judgement.notes);
}

ExitCode exit_code_of(const Judgement& judgement) { return exit_code_of(verdict_of(judgement)); }

}  // namespace tactbench::bench
