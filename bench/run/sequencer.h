// Carries out single steps on the chamber: ramp, settle, dwell, read, record. The layer above, conductor.h, handles
// faults.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bench/common/stop_request.h"
#include "bench/rig/rig.h"
#include "bench/run/control/control.h"
#include "bench/run/recorder.h"
#include "bench/run/time_estimate.h"
#include "bench/run/watch/watches.h"
#include "bench/safety/safe_state.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

class Sequencer {
 public:
  Sequencer(Rig& rig, Recorder& recorder, Control& control, const StopRequest& signals)
      : rig_(rig), recorder_(recorder), control_(control), signals_(signals), times_(rig.clock()) {}

  // The rules of the recipe (tolerances, retries, conditions) apply from now on. It must outlive this.
  void follow(const sequences::Recipe& recipe);
  // Reads the unloaded array and both pressures; throws Fault TB-CHAMBER-NOT-VENTED when the chamber is under pressure,
  // TB-CHAMBER-WITNESS when a reading cannot be true.
  UnloadedFrame read_unloaded_frame();

  // Between these two calls the measured reference must move in one direction, both on the way to the branch's first
  // level and from there on; else a step throws PathBroken. `tolerant`: a broken path is only flagged on its frames.
  void begin_branch(const sequences::Step& first, bool tolerant);
  void end_branch() { guard_.reset(); }
  void begin_step();  // starts the recipe's time limit for one step
  // A step of kind kConditioning or kMeasure. Throws Fault (devices, TB-CHAMBER-TIMEOUT, TB-CHAMBER-DISAGREE,
  // TB-CHAMBER-WITNESS, TB-STEP-TIMEOUT), RunEndRequested, Suspended, PathBroken.
  void chamber_step(const sequences::Step& step);
  // Reads all K scans and retries as the recipe allows; each failure is an event and sets `flags`.
  [[nodiscard]] devices::ScanSet read_array(std::string& flags);
  [[nodiscard]] const StepReadings& last() const { return readings_; }

  // Waits in slices, so that a command or a signal takes effect within 0.1 s of real time. Throws RunEndRequested,
  // Suspended.
  void wait_until(devices::Nanoseconds time);
  // Waits 0.2 s on a vented rig for a person, monitoring both pressures. Throws RunEndRequested.
  void idle();
  // Holds the present set-point for a moment, monitoring both pressures. Throws RunEndRequested, PathBroken.
  void stand();
  // Waits `duration_s` at 0 psi, feeding the module's watchdog and monitoring the pressures.
  void hold_vented(double duration_s);
  [[nodiscard]] const SuspensionWatch& conditions() const { return suspension_; }

  // True if a command or signal has requested the end; the next wait throws.
  [[nodiscard]] bool leaving() const { return control_.asked(signals_).has_value(); }
  // Called after each poll of commands and signals.
  void set_listener(std::function<void()> listener) { listener_ = std::move(listener); }
  // For a manual clock: limits process time to `rate` times real time, for people who watch.
  void pace(double rate) { pace_ = rate; }
  [[nodiscard]] TimeSpent& times() { return times_; }
  [[nodiscard]] Rig& rig() { return rig_; }
  // Starts a new path: pressure is 0, no dwell has begun.
  void forget() {
    setpoint_ = devices::Psi(0.0);
    moving_ = false;
  }
  // Passes the newest readings to Control; poll() does it for those of the chamber.
  void publish_readings();

 private:
  void watch_path(devices::Psi from, devices::Psi to);
  void ramp(const sequences::Step& step);
  void settle(const sequences::Step& step);
  void dwell(const sequences::Step& step);
  void poll();  // feeds the watchdog when due, reads both pressures, adds to the trace
  void check_agreement();
  void check_array();  // detects a scanner that repeats its last scan
  void add_flag(const std::string& flag);
  void check_conditions();
  void poll_commands();
  void keep_pace();
  Rig& rig_;
  Recorder& recorder_;
  Control& control_;
  const StopRequest& signals_;
  TimeSpent times_;
  std::function<void()> listener_;
  const sequences::Recipe* recipe_ = nullptr;
  StepReadings readings_;  // readings of the current step
  devices::Psi setpoint_{0.0};
  std::optional<BranchGuard> guard_;
  std::optional<devices::Nanoseconds> disagree_since_;  // since when feedback and reference disagree
  StuckRowWatch stuck_rows_;
  SuspensionWatch suspension_;
  devices::Nanoseconds polled_{0}, conditions_due_{0};
  devices::Nanoseconds last_frame_{0}, step_deadline_ = devices::Nanoseconds::max();
  bool left_band_ = false, tolerant_ = false, broken_ = false;
  double pace_ = 0.0;  // 0: no limit
  std::chrono::steady_clock::time_point paced_{};
  devices::Nanoseconds paced_at_{0};
  bool moving_ = false;  // the set-point is moving, or the pressure has not settled since
};

}  // namespace tactbench::bench
