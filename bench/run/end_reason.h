// Why a run ends: an operator's command, a fault, or both. One of them goes into the run's row, the other is recorded
// as an event.
#pragma once

#include <optional>
#include <string>

#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/run/control/control.h"
#include "bench/run/recorder.h"
#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

class EndReason {
 public:
  // Both must outlive this.
  EndReason(Control& control, const StopRequest& signals) : control_(control), signals_(signals) {}

  // To be called where an exception is caught: the run ends by that exception, or by a command that came before it. A
  // panic has precedence over any later fault, because the dead-man's vent makes the sequencer's next command fail.
  // Stop and abort have precedence over a failed device, which may have the same cause (Ctrl-C reaches every program of
  // a terminal), but not over a limit, a trip, a store error, or a chamber that is not safe.
  void by_exception(const std::string& where);
  // Ignored if the run already has a reason for its end.
  void by(const Error& error);
  // To be called after the teardown: a command other than stop that was received meanwhile becomes the reason of the
  // end if there is no other; otherwise it is recorded as an event. No command is accepted after this.
  void record_last_command(const std::string& where);

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }  // none: all steps were done
  [[nodiscard]] db::Outcome outcome() const;
  [[nodiscard]] bool store_failed() const { return store_failed_; }  // one of the faults was a store error
  void write(Recorder& recorder) const;                              // events of kind "fault" and "word"

 private:
  Control& control_;
  const StopRequest& signals_;
  std::optional<Error> error_;
  std::optional<Error> met_;           // a fault, when a command ended the run
  std::optional<Error> last_command_;  // accepted, but did not end the run
  std::optional<Command> heard_;       // the command that ended the run, if any
  bool store_failed_ = false;
};

// Describes a step of a run as text, for the progress line, `status` and `watch`.
// "conditioning 2 of 6"; "descending, step 19 of 217, repeat 1 of 5, unloading". `number`: of the step, from 1;
// `steps`: in the run.
std::string phase_of(const sequences::Step& step, const sequences::Recipe& recipe, int number, int steps);

}  // namespace tactbench::bench
