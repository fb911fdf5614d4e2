// The order of verdicts, and the overall verdict of several: the worst one. The store, JSON and people use a verdict's
// word; decisions compare the type.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/record.h"

namespace tactbench::analysis {

// Best first, so that the worse of two is the larger. kReportOnly (no statement of conformity) ranks best and is never
// stored.
enum class Verdict { kReportOnly, kPass, kConditionalPass, kConditionalFail, kInconclusive, kFail };
inline constexpr std::array kVerdicts = {Verdict::kReportOnly,      Verdict::kPass,         Verdict::kConditionalPass,
                                         Verdict::kConditionalFail, Verdict::kInconclusive, Verdict::kFail};

// "report only", "pass", "conditional pass", "conditional fail", "inconclusive", "fail".
const char* to_string(Verdict verdict);
std::optional<Verdict> verdict_from(std::string_view word);
// Empty where there is none.
std::string verdict_word(std::optional<Verdict> verdict);
// The words that a store may hold, best first.
std::vector<std::string> verdict_words();
// An unknown word counts as inconclusive.
Verdict verdict_in(const db::VerdictRecord& row);
// Whether the verdict states conformity or nonconformity: false without a verdict, and for report only.
bool states_conformity(std::optional<Verdict> verdict);

// Worst of the verdicts; none when there are no rows.
std::optional<Verdict> overall_verdict(std::span<const db::VerdictRecord> verdicts);

// The worst verdict of each run, in the order of the runs.
struct RunVerdict {
  std::int64_t run = 0;
  Verdict verdict = Verdict::kInconclusive;
};
std::vector<RunVerdict> verdicts_by_run(std::span<const db::VerdictRecord> verdicts);
// The runs whose verdict is the overall one, by number.
std::vector<std::int64_t> deciding_runs(std::span<const db::VerdictRecord> verdicts);

// For figures that are no evidence, such as those of the run that the models were made from: each verdict becomes
// "inconclusive", except "report only".
void withhold_verdicts(std::vector<db::VerdictRecord>& verdicts);

}  // namespace tactbench::analysis
