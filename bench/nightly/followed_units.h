// Converts trends of figures to the unit of pressure of the reader. Stores, JSON and baselines keep psi and the names
// with it.
#pragma once

#include "analysis/pressure_unit.h"
#include "bench/nightly/followed.h"

namespace tactbench::bench {

// A copy with the figures whose names have the unit psi ("mean_error_psi", "hold_drift_psi_per_min", "x_per_psi") in
// `unit`: their names ("mean_error_kpa"), values, bands, averages and slopes. Others are as they were.
Followed in_unit(Followed followed, analysis::PressureUnit unit);

}  // namespace tactbench::bench
