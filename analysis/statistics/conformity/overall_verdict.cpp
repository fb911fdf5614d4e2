#include "analysis/statistics/conformity/overall_verdict.h"

#include <algorithm>

namespace tactbench::analysis {
namespace {

constexpr std::array kVerdictWords = {"report only",      "pass",         "conditional pass",
                                      "conditional fail", "inconclusive", "fail"};
static_assert(kVerdictWords.size() == kVerdicts.size());

}  // namespace

const char* to_string(Verdict verdict) { return kVerdictWords.at(static_cast<std::size_t>(verdict)); }

std::optional<Verdict> verdict_from(std::string_view word) {
  for (const Verdict verdict : kVerdicts)
    if (word == to_string(verdict)) return verdict;
  return std::nullopt;
}

std::string verdict_word(std::optional<Verdict> verdict) { return verdict ? to_string(*verdict) : ""; }

std::vector<std::string> verdict_words() {
  std::vector<std::string> words;
  for (const Verdict verdict : kVerdicts)
    if (verdict != Verdict::kReportOnly) words.emplace_back(to_string(verdict));
  return words;
}

Verdict verdict_in(const db::VerdictRecord& row) { return verdict_from(row.verdict).value_or(Verdict::kInconclusive); }

bool states_conformity(std::optional<Verdict> verdict) { return verdict && *verdict != Verdict::kReportOnly; }

std::optional<Verdict> overall_verdict(std::span<const db::VerdictRecord> verdicts) {
  if (verdicts.empty()) return std::nullopt;
  Verdict worst = verdict_in(verdicts.front());
  for (const db::VerdictRecord& row : verdicts) worst = std::max(worst, verdict_in(row));
  return worst;
}

std::vector<RunVerdict> verdicts_by_run(std::span<const db::VerdictRecord> verdicts) {
  std::vector<RunVerdict> runs;
  for (const db::VerdictRecord& row : verdicts) {
    const auto known = std::ranges::find(runs, row.run, &RunVerdict::run);
    if (known == runs.end())
      runs.push_back({row.run, verdict_in(row)});
    else
      known->verdict = std::max(known->verdict, verdict_in(row));
  }
  return runs;
}

std::vector<std::int64_t> deciding_runs(std::span<const db::VerdictRecord> verdicts) {
  const std::optional<Verdict> overall = overall_verdict(verdicts);
  std::vector<std::int64_t> runs;
  for (const RunVerdict& run : verdicts_by_run(verdicts))
    if (run.verdict == overall) runs.push_back(run.run);
  std::ranges::sort(runs);
  return runs;
}

void withhold_verdicts(std::vector<db::VerdictRecord>& verdicts) {
  for (db::VerdictRecord& row : verdicts)
    if (verdict_in(row) != Verdict::kReportOnly) row.verdict = to_string(Verdict::kInconclusive);
}

}  // namespace tactbench::analysis
