// The run's row, written before any device is touched, and the checks that may refuse the run until then.
#pragma once

#include "bench/run/run_request.h"

namespace tactbench::db {
class RunStore;
}

namespace tactbench::bench {

// The columns of a run's row that identify the program.
db::RunRecord program_record();
db::RunRecord record_of(const RunRequest& request);
// The overrides of --set, from the text that record_of stores; none where the text is not of that kind.
std::optional<std::vector<sequences::Override>> stored_overrides(const std::string& overrides_json);
// The bench as the run had it, its seeds apart; none when its text can no longer be read.
std::optional<BenchConfig> stored_bench(const db::RunRecord& run);
// Throws Error TB-SENSOR-GEOMETRY when sensor type and scanner do not fit each other.
void check_geometry(const RunRequest& request);
// A resumed run continues with the devices that it began with. Throws Fault TB-RESUME-DEVICES.
void check_same_devices(const db::RunRecord& begun, const std::vector<db::DeviceRecord>& now);
// Stores the devices with the run when it has none yet; else as check_same_devices(). Throws Fault TB-DEVICE-NAME for a
// device that reports a model, serial number or firmware that the store does not accept.
void keep_devices(db::RunStore& store, std::int64_t run, const std::vector<db::DeviceRecord>& devices);
// Seconds since this sensor was last loaded, by the runs of the store before `run`; none: never.
std::optional<double> rest_of_sensor(const db::RunStore& store, const std::string& sensor_serial, std::int64_t run);

}  // namespace tactbench::bench
