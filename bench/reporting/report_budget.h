// What further runs of the sensor tell the uncertainty budgets: chamber and mounts from the studies, creep from holds,
// temperature from loops at another one. Runs are recognised by what they hold.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/report/runs.h"

namespace tactbench::bench {

// `input` has run, fit and studies already. `further`: runs after the report's; `studies`: words of --studies, of which
// only runs without a typed role count for creep and temperature.
analysis::UncertaintyInputs budget_inputs(analysis::Runs& runs, const analysis::ReportInput& input,
                                          const std::vector<std::int64_t>& further,
                                          const std::vector<std::string>& studies);

// What kept two runs apart beside their temperature, as far as the store knows: more than a day, or, of a simulated
// sensor, its age and its mount. Empty: nothing.
std::string other_state(const db::RunRecord& run, const db::RunRecord& other);

// The step of the run's thermometer in kelvin: of its register's scale, at least the last digit that is kept.
double thermometer_step_c(const db::RunRecord& run);

}  // namespace tactbench::bench
