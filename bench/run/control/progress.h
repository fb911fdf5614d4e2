// The progress line on standard error: on a terminal one line rewritten at 10 Hz, otherwise (or with CI set) a plain
// line every 10 s.
#pragma once

#include <chrono>
#include <string>

#include "sequences/step.h"

namespace tactbench::bench {

class Progress {
 public:
  enum class Mode { kQuiet, kPlain, kTerminal };
  explicit Progress(Mode mode) : mode_(mode) {}
  // kTerminal or kPlain by what standard error is; kQuiet when asked.
  static Mode mode_for(bool quiet);
  // `done` of `total` steps. Below 0, the time left follows from the pace so far.
  void step(const std::string& label, int done, int total, const sequences::Step& now, double left_s);
  // A line that stays, for what a person has to know now. Shown in every mode.
  void note(const std::string& text);
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  Mode mode_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_{};
  bool open_ = false;
};

}  // namespace tactbench::bench
