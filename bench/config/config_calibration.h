// The calibrations stated in a bench file: certificate, dates, U; and values that still say FILL-IN.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"

namespace tactbench::bench {

// "2026-01-31", or empty where the key is absent or empty. Throws FileError with place and form for anything else.
std::string read_date(const sequences::TomlTable& table, const std::string& key);

// Keys certificate, calibrated, due and `uncertainty_key`, 0 to `most`. Throws FileError.
StatedCalibration read_stated_calibration(const sequences::TomlTable& table, const std::string& uncertainty_key,
                                          double most);

// What the certificate covers and what it does not contain: keys certificate_covers, `drift_key`, `input_key`, 0 to
// `most`. A simulated bench that does not say has "chain". Throws FileError where they contradict each other.
void read_chain(const sequences::TomlTable& table, devices::Origin origin, const std::string& drift_key,
                const std::string& input_key, double most, StatedCalibration& stated);

// Every value that still says FILL-IN, with its place: "reference.certificate (bench.toml:77)".
std::vector<std::string> placeholders_of(const BenchConfig& config);

// Before anything is touched: throws Error, exit code 2, when a bench that drives hardware holds one
// (TB-BENCH-FILL-IN), or states a certificate without saying what it covers (TB-BENCH-COVERS). Stored bench files are
// read without it.
void refuse_placeholders(const BenchConfig& config);

}  // namespace tactbench::bench
