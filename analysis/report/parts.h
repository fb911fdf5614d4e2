// Shared by the report's sections, its data and the pages on several runs.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis/judgement/verdict.h"
#include "analysis/report/page/html.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

struct Pair {
  const char* name;
  html::Markup value;
};
html::Markup cell(const html::Safe& content);
html::Markup number_cell(const html::Safe& content);
html::Markup pairs_table(const char* caption, const std::vector<Pair>& rows);
// A level's pressure in the page's unit and in the other one: its two cells, and their headings over so many rows.
html::Markup level_headings(PressureUnit unit, int rows = 1);
html::Markup level_cells(double pressure_psi, PressureUnit unit);
const char* branch_in_words(bool up);  // "increasing", "decreasing" pressure
// ModelTaxel::full_scale(): of a loop with noise less than the highest reading of a sweep.
inline constexpr const char* kFullScaleOfModel =
    "the output at the end of the external loop where it is larger (of a rising sensor its highest pressure), mean of "
    "the sweeps there";
html::Markup section_start(const char* id, const char* title);
html::Markup code(const std::string& untrusted);
html::Text moment(const std::string& utc);       // "2024-05-06 07:08:09Z"
std::string place_of(int taxel, int columns);    // "row 1, column 5"
std::string model_name(const SensorModel& fit);  // "ELAM" for the paper's, else as tables name it

bool is_simulated(const ReportInput& input);
// The word "certificate" is allowed: an accreditation number and uncertainties are stated, the data are real, the
// pressure is traceable to a certificate of its reference that was in date.
bool is_certificate(const ReportInput& input);
// Without stated uncertainties a document is a test report.
bool states_uncertainty(const ReportInput& input);
std::string model_sha256(const SensorModel& fit);  // of all parameters and patterns, bit for bit
// A pressure reference that is a device of its own, not the regulator's feedback.
bool has_reference(const db::RunRecord& run);
// "✓ pass", "▲ inconclusive", "✗ fail"; with "simulated" before the word for a simulated run.
html::Markup verdict_mark(Verdict verdict, bool simulated);

struct Spread {
  double low, median, high;  // NaN when there is no finite value
  std::size_t count = 0;
};
Spread spread_of(std::vector<double> values);

// Mean and maximum of |a - b| over the pairs where both are finite ; NaN when there are none.
struct Deviation {
  double mean, maximum;
};
Deviation deviation(std::span<const double> a, std::span<const double> b);

int fitted_taxels(const SensorModel& fit);
// A figure over the observable taxels of a level: NaN where none is left, which the evaluation gives as 0.
double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted);

// States how compensation made a level worse than raw.
struct LevelJudgement {
  bool distance = false, std_up = false, std_down = false;
  [[nodiscard]] bool any() const { return distance || std_up || std_down; }
};
LevelJudgement judge_level(const LevelFigures& level);

}  // namespace tactbench::analysis
