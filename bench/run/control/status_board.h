// The sequencer's side of a run's status: what it writes here goes to the progress line and to those who ask the run.
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
  // To be changed freely; publish() then tells it. Readings come from the sequencer (Control::see).
  [[nodiscard]] RunStatus& now() { return now_; }
  void publish();
  // What the run does from now on, in words, published and shown.
  void phase(const std::string& words);
  // To be called often: renews the progress line when that is due.
  void refresh();
  // All steps up to now().step are done: a last one is shown even when nothing is due.
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
