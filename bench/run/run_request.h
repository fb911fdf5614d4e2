// The request for a run, and its result.
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

namespace tactbench::bench {

class MachineName;
class Rig;
class TimeEstimate;

// Moments at which tests inspect or break a simulated rig: before it is opened, before the unloaded frame, before the
// safe state, and at the end with the row closed.
enum class RigMoment { kMade, kOpened, kTearingDown, kLeft };

struct RunRequest {
  BenchConfig bench;
  db::SensorRecord sensor;  // as registered
  SensorType sensor_type;
  std::vector<sequences::Recipe> recipes;  // at least one
  std::string operator_name, purpose;
  std::vector<sequences::Override> overrides;  // as given, stored
  std::string specimen_state_file;             // simulation: read at the start if it exists, written at the end
  std::string label = "run";                   // of the progress line
  std::int64_t resume = 0;                     // a run of the store to continue; 0: a new one
  std::string on_event;                        // command for the events done, failed, waiting; empty: none
  bool assume_yes = false;                     // operator prompts are answered with yes
  bool check_seating = true;
  double pace = 0.0;  // of a bench simulated in this process: at most so many process seconds a real one; 0: no limit
  bool attended = true;                     // a person can resume it after a pause; else the first Ctrl-C ends it
  const MachineName* bench_name = nullptr;  // that the caller holds (BenchLock); null: the run takes one itself
  const TimeEstimate* estimate = nullptr;   // of time left; null: by the pace
  std::function<void(const sequences::Step&)> on_step;  // called with each step; may be empty
  std::function<void(std::int64_t)> on_begun;   // called with the run's number once its row exists; may be empty
  std::function<void(Rig&, RigMoment)> on_rig;  // called at each RigMoment; may be empty
};

struct RunResult {
  std::int64_t run = 0;
  db::Outcome outcome = db::Outcome::kIncomplete;
  db::SafeState safe = db::SafeState::kUnknown;
  analysis::PressureText safe_text;
  analysis::PressureText error_state;  // with an error: the proof, and what is kept of the run
  int frames = 0;                      // stored by this process
  std::int64_t frames_kept = 0;        // of the run in the store, including earlier processes
  int most_exchanges_a_step = 0;
  int branches_redone = 0;
  double process_seconds = 0.0;
  double waiting_seconds = 0.0;  // of process_seconds: for people and conditions
  double store_seconds = 0.0;    // real
  std::string time_spent;        // where the process time went, for people
  std::string content_sha256;
  std::optional<Error> error;  // why it did not complete; carries the exit code and the rig's state
};

}  // namespace tactbench::bench
