// The ladder of verdicts, and several of them together: the worst one counts, whatever the order they come in. The
// store, JSON and people have a verdict's word; what decides something compares the type.
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

// Best first, so that the worse of two is the larger. By a report-only file conformity is not stated: it is better than
// nothing, and no store keeps it.
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
// A word that is not on the ladder decides nothing and counts as inconclusive.
Verdict verdict_in(const db::VerdictRecord& row);
// Whether it says that something conforms or not: false without a verdict, and by a report-only file.
bool states_conformity(std::optional<Verdict> verdict);

// Worst of the verdicts; none when there are no rows.
std::optional<Verdict> overall_verdict(std::span<const db::VerdictRecord> verdicts);

// Of each run the worst of its criteria, in the order in which the runs come.
struct RunVerdict {
  std::int64_t run = 0;
  Verdict verdict = Verdict::kInconclusive;
};
std::vector<RunVerdict> verdicts_by_run(std::span<const db::VerdictRecord> verdicts);
// The runs whose verdict is the overall one, by number.
std::vector<std::int64_t> deciding_runs(std::span<const db::VerdictRecord> verdicts);

// For figures that are no evidence of what the sensor is worth, as those of the run that the models were made from:
// each verdict becomes "inconclusive", but of a report-only file.
void withhold_verdicts(std::vector<db::VerdictRecord>& verdicts);

}  // namespace tactbench::analysis
