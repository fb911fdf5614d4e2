// The run's row in the store, written before any device is touched, and the checks that may refuse the run before that.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/common/error.h"
#include "bench/config/config.h"
#include "db/record.h"
#include "sequences/recipe.h"

// The request for a run, and its result.

namespace tactbench::bench {

class MachineName;
class Rig;
class TimeEstimate;

// Moments at which tests inspect or break a simulated rig: before it is opened, before the unloaded frame, before the
// safe state, and at the end, with the row closed.
enum class RigMoment { kMade, kOpened, kTearingDown, kLeft };

struct RunRequest {
  BenchConfig bench;
  db::SensorRecord sensor;  // as registered
  SensorType sensor_type;
  std::vector<sequences::Recipe> recipes;  // at least one
  std::string operator_name, purpose;
  std::vector<sequences::Override> overrides;  // as given, stored
  std::string specimen_state_file;  // of a simulated sensor: read at the start if it exists, written at the end
  std::string label = "run";        // of the progress line
  std::int64_t resume = 0;          // stored run to continue; 0: a new run
  std::string on_event;             // command for the events done, failed, waiting; empty: none
  bool assume_yes = false;          // operator prompts are answered with yes
  bool check_seating = true;
  double pace =
      0.0;  // for a bench simulated in this process: at most so many process seconds per real second; 0: no limit
  bool attended = true;                     // a person can resume the run after a pause; else the first Ctrl-C ends it
  const MachineName* bench_name = nullptr;  // held by the caller (BenchLock); null: the run takes one itself
  const TimeEstimate* estimate = nullptr;   // estimate of the time left; null: by the pace so far
  std::function<void(const sequences::Step&)> on_step;  // called with each step; may be empty
  std::function<void(std::int64_t)> on_begun;   // called with the run's number once its row exists; may be empty
  std::function<void(Rig&, RigMoment)> on_rig;  // called at each RigMoment; may be empty
};

struct RunResult {
  std::int64_t run = 0;
  db::Outcome outcome = db::Outcome::kIncomplete;
  db::SafeState safe = db::SafeState::kUnknown;
  analysis::PressureText safe_text;
  analysis::PressureText error_state;  // with an error: proof of the safe state, and what is kept of the run
  int frames = 0;                      // stored by this process
  std::int64_t frames_kept = 0;        // frames of the run in the store, including earlier processes
  int most_exchanges_a_step = 0;
  int branches_redone = 0;
  double process_seconds = 0.0;
  double waiting_seconds = 0.0;  // part of process_seconds spent in waiting for people and conditions
  double store_seconds = 0.0;    // real
  std::string time_spent;        // breakdown of the process time as text
  std::string content_sha256;
  std::optional<Error> error;  // why the run did not complete, with exit code and the rig's state
};

}  // namespace tactbench::bench

namespace tactbench::db {
class RunReader;
class RunWriter;
}  // namespace tactbench::db

namespace tactbench::bench {

// The columns of a run's row that identify the program.
db::RunRecord program_record();
db::RunRecord record_of(const RunRequest& request);
// The overrides of --set, from the text that record_of stores; none if the text does not have that form.
std::optional<std::vector<sequences::Override>> stored_overrides(const std::string& overrides_json);
// The bench as in the run, except for the seeds; none if its text can no longer be read.
std::optional<BenchConfig> stored_bench(const db::RunRecord& run);
// Throws Error TB-SENSOR-GEOMETRY if sensor type and scanner have different rows and columns.
void check_geometry(const RunRequest& request);
// A resumed run continues with the devices that it began with. Throws Fault TB-RESUME-DEVICES.
void check_same_devices(const db::RunRecord& begun, const std::vector<db::DeviceRecord>& now);
// Stores the devices with the run if it has none yet; else compares them as check_same_devices() does. Throws Fault
// TB-DEVICE-NAME for a device that reports a model, serial number or firmware that the store does not accept.
void keep_devices(db::RunWriter& store, std::int64_t run, const std::vector<db::DeviceRecord>& devices);
// Seconds since this sensor was last loaded, by the runs of the store before `run`; none: never.
std::optional<double> rest_of_sensor(const db::RunReader& store, const std::string& sensor_serial, std::int64_t run);

}  // namespace tactbench::bench
