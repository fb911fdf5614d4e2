// Whether the instruments that results are held against are in date, in words: for devices check, plan and run.
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "bench/config/config.h"

namespace tactbench::bench {

// "certificate C-1, due 2027-01-31", "certificate not stated, OVERDUE since 2025-01-31", and what was not taken. `day`
// as 2026-01-31.
std::string calibration_words(const analysis::InstrumentCalibration& calibration, const std::string& day);

// What a person should know before a run, a line each: overdue instruments among `records`, values that were never
// filled in, texts that are no dates. None: nothing.
std::vector<std::string> calibration_warnings(const BenchConfig& config, const std::vector<db::DeviceRecord>& records,
                                              const std::string& day);

}  // namespace tactbench::bench
