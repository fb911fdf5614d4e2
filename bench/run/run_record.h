// What is written down of a run before a device is touched, and what is refused by then.
#pragma once

#include "bench/run/run_request.h"

namespace tactbench::db {
class RunStore;
}

namespace tactbench::bench {

// What any run says of the program that makes it.
db::RunRecord program_record();
db::RunRecord record_of(const RunRequest& request);
// What --set gave a run, as record_of stores it; none where the text is not of that kind.
std::optional<std::vector<sequences::Override>> stored_overrides(const std::string& overrides_json);
// Throws Error TB-SENSOR-GEOMETRY when sensor type and scanner do not fit each other.
void check_geometry(const RunRequest& request);
// A resumed run goes on with the very devices that it began with. Throws Fault TB-RESUME-DEVICES.
void check_same_devices(const db::RunRecord& begun, const std::vector<db::DeviceRecord>& now);
// Seconds since this sensor was last loaded, by the runs of the store before `run`; none: never.
std::optional<double> rest_of_sensor(const db::RunStore& store, const std::string& sensor_serial, std::int64_t run);

}  // namespace tactbench::bench
