// How a run reports without being asked: the progress line on standard error (on a terminal one line renewed at 10 Hz,
// otherwise, or with CI set, a plain line every 10 s and at the start of a phase, if a second has passed since the
// previous line), and the user's command for events.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "analysis/pressure_unit.h"
#include "bench/run/control/run_status.h"

namespace tactbench::bench {

// "run:   9 %  10:45 left  conditioning 2 of 6  60.0 psi (reference 43.2)". `left_s` in real seconds, below 0: not
// known.
std::string progress_line(const RunStatus& status, double left_s,
                          analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// Estimates the time left from the pace so far; starts again if the work went back to an earlier step or has rested.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Pace(Clock::time_point now = Clock::now()) : since_(now), seen_(now) {}
  // Seconds; below 0: not known.
  double left_s(Clock::time_point now, int step, int steps);

 private:
  Clock::time_point since_, seen_;
  int from_step_ = 0, seen_step_ = 0;
};

class Progress {
 public:
  enum class Mode { kQuiet, kPlain, kTerminal };
  explicit Progress(Mode mode, analysis::PressureUnit unit = analysis::PressureUnit::kPsi) : mode_(mode), unit_(unit) {}
  // kTerminal or kPlain, depending on standard error; kQuiet if `quiet`.
  static Mode mode_for(bool quiet);
  // Whether show() should be called now. In real time a run's first phase is shown immediately.
  [[nodiscard]] bool due(const RunStatus& status) const;
  // If process time has no fixed ratio to real time, the time left is estimated from the pace so far.
  void show(const RunStatus& status);
  // Prints a permanent line that the operator must see. Shown in every mode.
  void note(const std::string& text);
  void finish();

 private:
  using Clock = Pace::Clock;
  Mode mode_;
  analysis::PressureUnit unit_;
  Clock::time_point shown_ = Clock::now();
  Pace pace_;
  std::string phase_;  // shown last
  bool open_ = false;
};

// --on-event: runs the user's command when a run is done, has failed or waits for a person.
class Notify {
 public:
  Notify() = default;
  explicit Notify(std::string command) : command_(std::move(command)) {}
  // Starts `sh -c COMMAND` with TACTBENCH_EVENT (done, failed, waiting), TACTBENCH_RUN and TACTBENCH_REASON in its
  // environment and does not wait for it. A command that cannot be started is reported on standard error and changes
  // nothing.
  void run_command(const std::string& event, std::int64_t run, const std::string& reason) const;

 private:
  std::string command_;
};

}  // namespace tactbench::bench
