#include "bench/run/control/control.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace tactbench::bench {

const char* to_string(Command command) {
  constexpr std::array<const char*, 6> kNames = {"status", "pause", "resume", "stop", "abort", "panic"};
  return kNames.at(static_cast<std::size_t>(command));
}

Control::Answer Control::ask(Command command, const std::string& who) {
  Answer answer{true, {}};
  bool panic = false;
  {
    const std::lock_guard lock(mutex_);
    const RunState state = status_.state;
    const bool waits = state == RunState::kPaused || state == RunState::kPausing || pause_;
    if (command == Command::kStatus) return {true, to_string(state)};
    if (closed_ || state == RunState::kStopping || state == RunState::kEnded) {
      const RunState ending = state == RunState::kEnded ? state : RunState::kStopping;
      return {false, fmt::format("run {} is {} already", status_.run, to_string(ending))};
    }
    if (finished_ && command < Command::kAbort) {
      return {false, fmt::format("run {} has done all its steps: it vents, retracts, proves it and ends", status_.run)};
    }
    if (command == Command::kPause) {
      if (state == RunState::kPaused) return {false, fmt::format("run {} is paused already", status_.run)};
      pause_ = true;
      resume_ = false;
      answer.text = fmt::format("run {} pauses at the end of this branch; 'stop' ends it at once", status_.run);
    } else if (command == Command::kResume) {
      if (!waits) return {false, fmt::format("run {} is {}, not paused", status_.run, to_string(state))};
      pause_ = false;
      resume_ = true;
      answer.text = fmt::format("run {} continues: {}", status_.run,
                                !status_.question.empty()    ? "it takes this as the answer to: " + status_.question
                                : state == RunState::kPaused ? "conditioned again, then the next branch"
                                                             : "the pause is taken back");
    } else {
      if (command > command_) leaver_ = who;
      command_ = std::max(command_, command);
      panic = command == Command::kPanic;
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
  RunStatus status = status_;
  status.age_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - told_).count();
  return status;
}

std::optional<Leave> Control::leave(const StopRequest& signals) const {
  if (command_ == Command::kPanic) return Leave{command_, 0, leaver_};
  if (const int number = signals.ending(); number != 0) return Leave{Command::kStop, number, signal_text(number)};
  if (signals.interrupts() - interrupts_answered_ >= interrupts_that_end_) {
    return Leave{Command::kStop, SIGINT, signal_text(SIGINT)};
  }
  if (command_ != Command::kStatus) return Leave{command_, 0, leaver_};
  return std::nullopt;
}

void Control::poll(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  if (const auto leaving = leave(signals)) throw *leaving;
  const int interrupts = signals.interrupts();
  if (interrupts > interrupts_seen_) {
    pause_ = true;
    who_ = "Ctrl-C";
  }
  interrupts_seen_ = interrupts;
}

std::optional<Leave> Control::asked(const StopRequest& signals) const {
  const std::lock_guard lock(mutex_);
  return leave(signals);
}

void Control::finish(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  if (const auto leaving = leave(signals)) throw *leaving;
  finished_ = true;
}

std::optional<Leave> Control::close(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  return leave(signals);
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
  const std::optional<RunReadings> readings = status_.readings;
  status_ = status;
  status_.readings = readings;
  told_ = std::chrono::steady_clock::now();
}

void Control::see(const RunReadings& readings) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  status_.readings = readings;
  told_ = std::chrono::steady_clock::now();
}

std::string Control::who() const {
  const std::lock_guard lock(mutex_);
  return who_;
}

}  // namespace tactbench::bench
