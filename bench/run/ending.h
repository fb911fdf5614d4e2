// Why a run ends: an operator's word, a fault, or both at once. One of them goes into the run's row, the other stays
// beside it as an event of the record.
#pragma once

#include <optional>
#include <string>

#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/run/control/control.h"
#include "bench/run/recorder.h"
#include "db/run_store.h"

namespace tactbench::bench {

class Ending {
 public:
  // Both outlive this.
  Ending(Control& control, const StopRequest& signals) : control_(control), signals_(signals) {}

  // To be called where an exception is caught: by that one, or by a word that was taken before it. A panic wins over
  // whatever fault follows it: the dead-man's vent is what the sequencer's next command meets. Stop and abort win where
  // a device failed, which may be of the same hand (Ctrl-C reaches every program of a terminal); not over a limit, a
  // trip, the store, or a chamber that is not safe.
  void by_exception(const std::string& where);
  // Unless something else has ended it.
  void by(const Error& error);
  // Once the work and the way out are done: a word that was taken since then ends a run that nothing else has ended,
  // unless it is a stop, and is kept beside whatever did. No word is taken after this.
  void hear_last_words(const std::string& where);

  [[nodiscard]] const std::optional<Error>& error() const { return error_; }  // none: all was done
  [[nodiscard]] db::Outcome outcome() const;
  [[nodiscard]] bool met_store() const { return met_store_; }  // a fault of the store was among it
  void write(Recorder& recorder) const;                        // events of kind "fault" and "word"

 private:
  Control& control_;
  const StopRequest& signals_;
  std::optional<Error> error_;
  std::optional<Error> met_;        // the fault beside the word that ended the run
  std::optional<Error> last_word_;  // taken, and not what ended the run
  std::optional<Command> heard_;    // the command that ended the run, if any
  bool met_store_ = false;
};

}  // namespace tactbench::bench
