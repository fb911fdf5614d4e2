// The calibrations stated in a bench file: certificate, dates, U, values that are still FILL-IN; and their status as
// text.
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/instruments.h"
#include "bench/config/config.h"
#include "sequences/step.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

// A date as "2026-01-31"; empty if the key is absent or empty. Throws FileError with place and format for anything
// else.
sequences::Key date_key(const char* name, std::string& date, const char* meaning);

// certificate, calibrated, due and the expanded uncertainty (key and unit of the instrument, 0 to 10).
sequences::KeyTable stated_keys(StatedCalibration& stated, const char* uncertainty_key, const sequences::Unit& unit,
                                const char* certificate_meaning, const char* uncertainty_meaning);
// Throws FileError where the dates contradict each other.
void check_dates(const sequences::TomlTable& table, const StatedCalibration& stated);

// Keys that state what the certificate covers and does not cover: certificate_covers, drift, and the limit of error of
// the input that reads the instrument (keys and units of the instrument, 0 to 10). The default on a simulated bench is
// "chain".
struct ChainKeys {
  const char *drift, *drift_unit, *input, *input_unit, *covers_meaning, *input_meaning;
};
sequences::KeyTable chain_keys(StatedCalibration& stated, devices::Origin origin, const ChainKeys& names);
// Throws FileError if the keys contradict each other.
void check_chain(const sequences::TomlTable& table, const StatedCalibration& stated, const std::string& input_key);

// Every value that is still FILL-IN, with its place: "reference.certificate (bench.toml:77)".
std::vector<std::string> placeholders_of(const BenchConfig& config);

// Called before any device is touched: throws Error, exit code 2, if the file of a bench with hardware contains a
// FILL-IN (TB-BENCH-FILL-IN), or a certificate without what it covers (TB-BENCH-COVERS). Stored bench files are read
// without this check.
void refuse_placeholders(const BenchConfig& config);

// Calibration status of the instruments that results are traced to, as text for `devices check`, `plan` and `run`.
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
