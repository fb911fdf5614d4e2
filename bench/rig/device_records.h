// The record that a run keeps of each instrument: identity, scaling, range, and its calibration as stated in the bench
// file.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "db/record.h"

namespace tactbench::bench {

// What an open force sensor reports about itself.
struct ForceIdentity {
  devices::Identity identity;
  std::string calibration;        // its id
  std::array<double, 6> range{};  // N, N mm
};

db::DeviceRecord module_record(const devices::Identity& identity, const devices::ModuleProfile& profile);
db::DeviceRecord regulator_record(const devices::Identity& identity, const BenchConfig& config);
db::DeviceRecord reference_record(const devices::Identity& identity, const BenchConfig& config);
db::DeviceRecord environment_record(const EnvironmentSensor& sensor, const BenchConfig& config);
db::DeviceRecord scanner_record(const devices::Identity& identity, double volts_per_count, const BenchConfig& config);
db::DeviceRecord force_record(const ForceIdentity& force, const ForceConfig& config);
// `axis`: 0, 1, 2 for x, y, z.
db::DeviceRecord stage_record(const devices::Identity& identity, std::size_t axis, const StageConfig& config);

// The instruments that results are traced to, as the bench file names them; queries no instrument. Pressure reference;
// stage and force sensor where the bench has them and `presses`.
std::vector<db::DeviceRecord> stated_instruments(const BenchConfig& config, bool presses);

}  // namespace tactbench::bench
