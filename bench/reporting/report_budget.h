// Contributions of further runs to the uncertainty budgets: chamber uniformity and mounting from the studies, creep
// from holds, temperature from loops at another temperature, dwell time and history from further and held-out runs. A
// study's role is typed with it; the kind of any other run is recognised from its data and its record.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/report/gather.h"
#include "analysis/report/report.h"

namespace tactbench::bench {

// `input` already has run, fit and studies. `further`: other runs than the report's; `studies`: arguments of --studies;
// only runs without a typed role count for creep and temperature.
analysis::UncertaintyInputs budget_inputs(analysis::Runs& runs, const analysis::ReportInput& input,
                                          const std::vector<std::int64_t>& further,
                                          const std::vector<std::string>& studies);

// Held-out runs grouped by the difference between their conditions and the calibration's; runs under an indenter are
// left out.
analysis::HistoryRuns held_out_histories(analysis::Runs& runs, std::int64_t calibration,
                                         const std::vector<std::int64_t>& held_out);

struct StateChange {
  bool later = false, mounted = false,
       unknown = false;  // later: another day or age; mounted: mounted again; unknown: cannot be determined
  std::string text;      // the first of these differences as text; empty: none
  [[nodiscard]] bool any() const { return !text.empty(); }
};
StateChange state_change(const db::RunRecord& run, const db::RunRecord& other);

// Other differences between two runs besides temperature, as far as recorded in the store: more than a day between
// them, or, for a simulated sensor, age and mount. Empty: none.
std::string other_state(const db::RunRecord& run, const db::RunRecord& other);

// Whether two runs differ in temperature, by their thermometers or, for a simulated sensor, by its configuration.
bool temperature_differs(const db::RunRecord& run, const db::RunRecord& other, const analysis::Dataset& ours,
                         const analysis::Dataset& theirs);

// Resolution of the run's thermometer in kelvin: one count of its register, at least the last stored digit.
double thermometer_step_c(const db::RunRecord& run);

}  // namespace tactbench::bench
