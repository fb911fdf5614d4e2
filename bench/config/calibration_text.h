// Calibration status of the instruments that results are traced to, as text for `devices check`, `plan` and `run`.
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instruments.h"
#include "bench/config/config.h"
#include "sequences/step.h"

namespace tactbench::bench {

// "certificate C-1, due 2027-01-31", "certificate not stated, OVERDUE since 2025-01-31", and which statements of the
// file were not used. `day` as 2026-01-31.
std::string calibration_text(const analysis::InstrumentCalibration& calibration, const std::string& day,
                             analysis::PressureUnit unit);

// Warnings before a run of `steps`, one line each: overdue instruments among `records`, pressures beyond the
// reference's certificate, values that still say FILL-IN.
std::vector<std::string> calibration_warnings(const BenchConfig& config, const std::vector<db::DeviceRecord>& records,
                                              const std::string& day, const std::vector<sequences::Step>& steps,
                                              analysis::PressureUnit unit);

}  // namespace tactbench::bench
