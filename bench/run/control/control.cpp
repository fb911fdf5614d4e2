#include "bench/run/control/control.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace tactbench::bench {

const char* to_string(Command command) {
  constexpr std::array<const char*, 6> kWords = {"status", "pause", "resume", "stop", "abort", "panic"};
  return kWords.at(static_cast<std::size_t>(command));
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
      return {false, fmt::format("run {} has done all its steps: it vents, retracts, proves the safe state and ends",
                                 status_.run)};
    }
    if (command == Command::kPause) {
      if (state == RunState::kPaused) return {false, fmt::format("run {} is paused already", status_.run)};
      pause_ = true;
      resume_ = false;
      answer.text = fmt::format("run {} pauses at the end of this branch; 'stop' ends it at once", status_.run);
    } else if (command == Command::kResume) {
      if (!waits) return {false, fmt::format("run {} is {}, not paused", status_.run, to_string(state))};
      if (!status_.question.empty()) {
        if (Answer reply = accept_answer(status_.question_id, {}, who); !reply.taken) return reply;
      }
      pause_ = false;
      resume_ = true;
      answer.text = fmt::format("run {} continues: {}", status_.run,
                                !status_.question.empty()    ? "it accepts this as the answer to: " + status_.question
                                : state == RunState::kPaused ? "conditioned again, then the next branch"
                                                             : "the pause is revoked");
    } else {
      if (command > command_) end_requested_by_ = who;
      command_ = std::max(command_, command);
      panic = command == Command::kPanic;
      answer.text =
          fmt::format("run {} ends: {}", status_.run,
                      panic ? "vented and halted without the sequencer" : "vents, retracts and proves the safe state");
    }
    who_ = who;
  }
  if (panic && panic_) panic_();
  return answer;
}

Control::Answer Control::answer(int question, const std::string& text, const std::string& who) {
  const std::lock_guard lock(mutex_);
  if (closed_ || status_.state == RunState::kStopping || status_.state == RunState::kEnded)
    return {false, fmt::format("run {} is ending and does not wait for an answer", status_.run)};
  return accept_answer(question, text, who);
}

Control::Answer Control::accept_answer(int question, const std::string& text, const std::string& who) {
  if (answer_ && answer_->question == question)
    return {false, fmt::format("question {} was already answered by {}", question, answer_->who)};
  if (status_.question.empty() || status_.question_id != question)
    return {false, fmt::format("run {} does not wait for an answer to question {}", status_.run, question)};
  answer_ = GivenAnswer{question, text, who};
  who_ = who;
  ++news_;
  return {true, fmt::format("run {} continues: question {} is answered", status_.run, question)};
}

std::optional<GivenAnswer> Control::answer_to(int question) const {
  const std::lock_guard lock(mutex_);
  return answer_ && answer_->question == question ? answer_ : std::nullopt;
}

RunStatus Control::status() const {
  const std::lock_guard lock(mutex_);
  RunStatus status = status_;
  status.answer = answer_;
  status.age_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - reported_at_).count();
  return status;
}

std::optional<RunEndRequested> Control::leave(const StopRequest& signals) const {
  if (command_ == Command::kPanic) return RunEndRequested{command_, 0, end_requested_by_};
  if (const int number = signals.ending(); number != 0)
    return RunEndRequested{Command::kStop, number, signal_text(number)};
  if (signals.interrupts() - interrupts_answered_ >= interrupts_that_end_) {
    return RunEndRequested{Command::kStop, SIGINT, signal_text(SIGINT)};
  }
  if (command_ != Command::kStatus) return RunEndRequested{command_, 0, end_requested_by_};
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

std::optional<RunEndRequested> Control::asked(const StopRequest& signals) const {
  const std::lock_guard lock(mutex_);
  return leave(signals);
}

void Control::finish(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  if (const auto leaving = leave(signals)) throw *leaving;
  finished_ = true;
}

std::optional<RunEndRequested> Control::close(const StopRequest& signals) {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  return leave(signals);
}

bool Control::pause_wanted() const {
  const std::lock_guard lock(mutex_);
  return pause_;
}

bool Control::consume_resume() {
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
  reported_at_ = std::chrono::steady_clock::now();
  ++news_;
}

void Control::see(const RunReadings& readings) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  status_.readings = readings;
  reported_at_ = std::chrono::steady_clock::now();
  ++news_;
}

std::string Control::who() const {
  const std::lock_guard lock(mutex_);
  return who_;
}

void StatusBoard::publish() {
  const double by_pace = pace_.left_s(Pace::Clock::now(), now_.step, now_.steps);
  if (now_.left_high_s <= 0.0) now_.left_s = std::max(by_pace, 0.0) * (now_.rate > 0.0 ? now_.rate : 1.0);
  control_.publish(now_);
}

void StatusBoard::phase(const std::string& text) {
  now_.phase = text;
  publish();
  refresh();
}

void StatusBoard::refresh() {
  if (progress_.due(now_)) progress_.show(control_.status());
}

void StatusBoard::step_done() {
  if (now_.step == now_.steps || progress_.due(now_)) progress_.show(control_.status());
}

}  // namespace tactbench::bench
