// The report's sections, one function each, and what they share. Every section is a pure function of the input.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/html.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

// report.cpp puts these one after the other.
html::Markup verdict_section(const ReportInput& input);
html::Markup identification_section(const ReportInput& input);
html::Markup health_section(const ReportInput& input);
html::Markup raw_section(const ReportInput& input);
html::Markup loops_section(const ReportInput& input);
html::Markup frames_section(const ReportInput& input);
html::Markup levels_section(const ReportInput& input);
html::Markup model_section(const ReportInput& input);
html::Markup held_out_section(const ReportInput& input);
html::Markup uncertainty_section(const ReportInput& input);
html::Markup meaning_section(const ReportInput& input);

// Parts of the identification.
html::Markup instruments_part(const ReportInput& input);
html::Markup method_part(const ReportInput& input);

// The data behind the figures. What names the run (number, UUID, times, host) is apart from the results, so that the
// content hash can leave it out. JSON in ASCII; null where a figure is not available.
std::string identification_json(const ReportInput& input);
std::string results_json(const ReportInput& input);
std::string uncertainty_json(const ReportInput& input);
// ,"creep":{...},"temperature":{...}: what the budgets take of them; nothing of what is not assessed.
std::string effects_members(const Uncertainty& uncertainty);
std::string number_list_json(const std::vector<double>& values);  // null where not finite
std::string health_json(const ReportInput& input);
std::string behaviour_json(const ReportInput& input);

// Shared by the sections.
struct Pair {
  const char* name;
  html::Markup value;
};
html::Markup cell(const html::Safe& content);
html::Markup number_cell(const html::Safe& content);
html::Markup pairs_table(const char* caption, const std::vector<Pair>& rows);
html::Markup section_start(const char* id, const char* title);
html::Markup code(const std::string& untrusted);
html::Text moment(const std::string& utc);     // "2024-05-06 07:08:09Z"
std::string place_of(int taxel, int columns);  // "row 1, column 5"

bool is_simulated(const ReportInput& input);
// The word "certificate" is allowed: an accreditation number is stated, the data are real, the pressure is traceable.
bool is_certificate(const ReportInput& input);
// A due date lies before the day of `utc`; false where one of them is no date.
bool is_overdue(const std::string& due, const std::string& utc);
std::string model_sha256(const ArrayFit& fit);  // of all parameters and patterns, bit for bit
// A pressure reference that is a device of its own, not the regulator's feedback.
bool has_reference(const db::RunRecord& run);
// "✓ pass", "▲ inconclusive", "✗ fail"; with "simulated" before the word for a simulated run.
html::Markup verdict_mark(const std::string& verdict, bool simulated);
// Worst of the verdicts; empty when there are none.
std::string overall_verdict(std::span<const db::VerdictRecord> verdicts);

struct Spread {
  double low, median, high;  // NaN when there is no finite value
  std::size_t count = 0;
};
Spread spread_of(std::vector<double> values);

// Mean and maximum of |a - b| over the pairs where both are finite (Eq. 49); NaN when there are none.
struct Deviation {
  double mean, maximum;
};
Deviation deviation(std::span<const double> a, std::span<const double> b);

int fitted_taxels(const ArrayFit& fit);
// A figure over the observable taxels of a level: NaN where none is left, which the evaluation gives as 0.
double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted);

// In which way compensation made a level worse than it was raw.
struct LevelJudgement {
  bool distance = false, std_up = false, std_down = false;
  [[nodiscard]] bool any() const { return distance || std_up || std_down; }
};
LevelJudgement judge_level(const LevelFigures& level);

}  // namespace tactbench::analysis
