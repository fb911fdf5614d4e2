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
// Throws Error TB-SENSOR-GEOMETRY when sensor type and scanner do not fit each other.
void check_geometry(const RunRequest& request);
// A resumed run continues with the devices that it began with. Throws Fault TB-RESUME-DEVICES.
void check_same_devices(const db::RunRecord& begun, const std::vector<db::DeviceRecord>& now);
// Keeps them with the run where none are kept yet; else as check_same_devices(). Throws Fault TB-DEVICE-NAME for one
// that tells a model, serial number or firmware that no store takes.
void keep_devices(db::RunStore& store, std::int64_t run, const std::vector<db::DeviceRecord>& devices);
// Seconds since this sensor was last loaded, by the runs of the store before `run`; none: never.
std::optional<double> rest_of_sensor(const db::RunStore& store, const std::string& sensor_serial, std::int64_t run);

}  // namespace tactbench::bench
