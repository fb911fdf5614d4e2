// The sequencer's side of a run's status: it is shown in the progress line and sent to clients of the run.
// One thread; nothing here waits for a reader.
#pragma once

#include <string>

#include "bench/run/control/control.h"
#include "bench/run/control/progress.h"

namespace tactbench::bench {

class StatusBoard {
 public:
  // Both must outlive this.
  StatusBoard(Control& control, Progress& progress) : control_(control), progress_(progress) {}
  // The status to be changed; publish() then sends it. Readings come from the sequencer (Control::see).
  [[nodiscard]] RunStatus& now() { return now_; }
  void publish();
  // Sets the run's current activity in words, publishes and shows it.
  void phase(const std::string& words);
  // To be called often: renews the progress line when that is due.
  void refresh();
  // To be called when all steps up to now().step are done: the last step is always shown.
  void step_done();
  void note(const std::string& text) { progress_.note(text); }
  [[nodiscard]] Progress& progress() { return progress_; }

 private:
  Control& control_;
  Progress& progress_;
  RunStatus now_;
  Pace pace_;
};

}  // namespace tactbench::bench
