#include "bench/run/control.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace tactbench::bench {

const char* to_string(Word word) {
  constexpr std::array<const char*, 6> kWords = {"status", "pause", "resume", "stop", "abort", "panic"};
  return kWords.at(static_cast<std::size_t>(word));
}

Control::Answer Control::ask(Word word, const std::string& who) {
  Answer answer{true, {}};
  bool panic = false;
  {
    const std::lock_guard lock(mutex_);
    const RunState state = status_.state;
    const bool waits = state == RunState::kPaused || state == RunState::kPausing || pause_;
    if (word == Word::kStatus) return {true, to_string(state)};
    if (state == RunState::kStopping || state == RunState::kEnded) {
      return {false, fmt::format("run {} is {} already", status_.run, to_string(state))};
    }
    if (word == Word::kPause) {
      if (state == RunState::kPaused) return {false, fmt::format("run {} is paused already", status_.run)};
      pause_ = true;
      resume_ = false;
      answer.text = fmt::format("run {} pauses at the end of this branch; 'stop' ends it at once", status_.run);
    } else if (word == Word::kResume) {
      if (!waits) return {false, fmt::format("run {} is {}, not paused", status_.run, to_string(state))};
      pause_ = false;
      resume_ = true;
      answer.text = fmt::format("run {} goes on: conditioned again, then the next branch", status_.run);
    } else {
      word_ = std::max(word_, word);
      panic = word == Word::kPanic;
      answer.text = fmt::format("run {} ends: {}", status_.run,
                                panic ? "vented and halted past the sequencer" : "vents, retracts and proves it");
    }
    who_ = who;
  }
  if (panic && panic_) panic_();
  return answer;
}

RunStatus Control::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Control::look(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  if (signals.terminate()) throw Leave{Word::kStop, SIGTERM, "a request to terminate"};
  const int interrupts = signals.interrupts();
  if (interrupts - interrupts_answered_ >= 2) throw Leave{Word::kStop, SIGINT, "Ctrl-C"};
  if (interrupts > interrupts_seen_) {
    pause_ = true;
    who_ = "Ctrl-C";
  }
  interrupts_seen_ = interrupts;
  if (word_ != Word::kStatus) throw Leave{word_, 0, who_};
}

bool Control::pause_wanted() const {
  const std::lock_guard lock(mutex_);
  return pause_;
}

bool Control::take_resume() {
  const std::lock_guard lock(mutex_);
  if (resume_) {
    pause_ = false;
    interrupts_answered_ = interrupts_seen_;
  }
  return std::exchange(resume_, false);
}

void Control::publish(const RunStatus& status) {
  const std::lock_guard lock(mutex_);
  status_ = status;
}

std::string Control::who() const {
  const std::lock_guard lock(mutex_);
  return who_;
}

}  // namespace tactbench::bench
