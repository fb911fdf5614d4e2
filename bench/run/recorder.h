// Writes a run to the store: one frame per step with the trace since the previous frame, branches with their attempts,
// and the state of the run. It is the only writer of a live run. Data that cannot be written because another program
// has locked the store are queued here in order.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/control/run_status.h"
#include "db/run_store.h"
#include "devices/pressure/pressure_source.h"
#include "devices/tactile/tactile_array.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

class Progress;
class Rig;

struct StepReadings {
  std::uint16_t setpoint_counts = 0;
  devices::PressureReading feedback, reference;
  devices::ScanSet scans;
  devices::Nanoseconds commanded_at{0}, in_band_since{0};
  int exchanges = 0;
  std::string flags;
  std::optional<db::WrenchRecord> wrench;
};

class Recorder {
 public:
  // `offset` is added to the clock's time, so that the time of a resumed run continues. The count of attempts continues
  // from the stored ones.
  Recorder(db::RunWriter& store, std::int64_t run, const devices::Clock& clock, devices::Nanoseconds offset = {});

  // Transformation of texts before they are stored (bench/simulation/ephemeral_addresses.h); without it they are stored
  // unchanged.
  void name_by(std::function<std::string(const std::string&)> names) { names_ = std::move(names); }
  [[nodiscard]] std::string as_stored(const std::string& text) const { return names_ ? names_(text) : text; }

  // Called between two attempts while the store is locked, with the error and the seconds waited so far. It may throw;
  // false: the work continues, and the queue is written later. Without a handler the recorder waits 5 s.
  using OnLockRetry = std::function<bool(const db::StoreError& locked, double waited_s)>;
  void when_locked(OnLockRetry handler) { on_lock_retry_ = std::move(handler); }
  // Executes `job`, one transaction of the store, after the queue. A job that found the store locked is repeated
  // unchanged, possibly after this has returned or thrown.
  void write(std::function<void()> job);
  // Writes the queue; false: the store is still locked, and locked() says by whom.
  [[nodiscard]] bool flush();
  [[nodiscard]] const std::optional<db::StoreError>& locked() const { return locked_; }

  void open_branch(const sequences::Step& step);                          // the next attempt at the step's branch
  void void_branch(const std::string& reason);                            // voids the open branch, if there is one
  void void_repeat(int sequence, int repeat, const std::string& reason);  // voids all branches of the repeat so far
  void close_branch() { branch_ = 0; }
  // One reading of the pressures, kept until the next frame is stored with all of them.
  void poll(devices::Psi setpoint, const devices::PressureReading& feedback, const devices::PressureReading& reference);
  void frame(const sequences::Step& step, const StepReadings& readings);
  void event(const std::string& kind, const std::string& id, const std::string& detail);
  void log(const std::string& kind, const std::string& id, const std::string& detail);  // an event; never waits
  void check(const std::string& kind, const std::string& verdict, const std::string& detail_json,
             std::vector<double> data);
  // Throws std::logic_error on a change that the table does not allow.
  void state(RunState next, const std::string& reason);
  void end(db::Outcome outcome, const std::string& reason, db::SafeState safe);
  [[nodiscard]] RunState state() const { return state_; }
  [[nodiscard]] int frames() const { return frames_; }                     // frames stored by this process
  [[nodiscard]] std::int64_t void_frames() const { return void_frames_; }  // including earlier processes
  [[nodiscard]] int max_exchanges() const { return max_exchanges_; }
  [[nodiscard]] std::int64_t run() const { return run_; }
  // Process time since the run's start, including earlier processes.
  [[nodiscard]] double elapsed_s() const { return static_cast<double>(now_ns()) * 1e-9; }
  [[nodiscard]] double store_seconds() const { return store_seconds_; }  // real time spent in storing frames

 private:
  [[nodiscard]] std::function<void()> storing(const std::string& kind, const std::string& id,
                                              const std::string& detail);
  [[nodiscard]] std::int64_t now_ns() const { return (clock_.now() + offset_).count(); }
  struct Poll {
    devices::Nanoseconds time{0};
    float setpoint_psi = 0.0F, feedback_psi = 0.0F, reference_psi = 0.0F;
  };
  db::RunWriter& store_;
  std::int64_t run_;
  const devices::Clock& clock_;
  devices::Nanoseconds offset_;
  RunState state_ = RunState::kPrepared;
  std::int64_t branch_ = 0;  // 0: none is open
  std::map<sequences::BranchKey, int> attempts_;
  std::vector<Poll> polls_;
  std::deque<std::function<void()>> waiting_;
  std::optional<db::StoreError> locked_;
  std::chrono::steady_clock::time_point next_try_{};
  OnLockRetry on_lock_retry_;
  std::function<std::string(const std::string&)> names_;
  int frames_ = 0, max_exchanges_ = 0;
  std::int64_t void_frames_ = 0;
  double store_seconds_ = 0.0;
};

// Reports notices of the dead-man and of busy modules to the run's record and to the operator.
// Reports the notices since the last call: for the dead-man an event of kind "dead-man" and a printed note each, for a
// busy module an event of kind "warning" (TB-MODBUS-BUSY).
void record_notices(Rig& rig, Recorder& recorder, Progress& progress);
// Prints the dead-man's notices, for verbs without a run record: one line each on standard error.
void print_dead_man_notices(Rig& rig);
// Throws Fault TB-DEADMAN-SILENT, TB-DEADMAN-ENDED, TB-DEADMAN-BLIND when it no longer watches.
void check_dead_man(Rig& rig);

}  // namespace tactbench::bench
