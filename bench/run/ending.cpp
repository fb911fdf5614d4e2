#include "bench/run/ending.h"

#include <fmt/format.h>

#include <csignal>

namespace tactbench::bench {

namespace {

Error error_of(const Leave& leave, const std::string& where) {
  if (leave.word != Word::kStop) {
    const bool panic = leave.word == Word::kPanic;
    return {ExitCode::kStopped, panic ? "TB-RUN-PANIC" : "TB-RUN-ABORTED",
            fmt::format("{} by {}", panic ? "panic" : "aborted", leave.who), where,
            "look at the rig before the next run; the frames so far are kept"};
  }
  const ExitCode code = leave.signal == SIGINT ? ExitCode::kInterrupted
                        : leave.signal != 0    ? ExitCode::kTerminated
                                               : ExitCode::kStopped;
  return {code, "TB-RUN-STOPPED", "stopped by " + leave.who, where,
          "the frames so far are kept; `tactbench resume` goes on with the branch that was under way"};
}

bool word_wins(const Leave& leave, const Error& met) {
  return leave.word == Word::kPanic || met.code() == ExitCode::kDevice;
}

// 7 outranks all other exit codes.
Error with_fault(const Error& word, const Error& met) {
  const ExitCode code = met.code() == ExitCode::kUnsafe ? ExitCode::kUnsafe : word.code();
  return {code, word.id(), fmt::format("{}; met on the way out: {}", word.what(), met.id()), word.where(),
          word.remedy()};
}

}  // namespace

void Ending::by_exception(const std::string& where) {
  try {
    throw;
  } catch (const Leave& leave) {
    heard_ = leave.word;
    error_ = error_of(leave, where);
  } catch (...) {
    const Error met = as_error(std::current_exception(), where);
    met_store_ = met_store_ || met.code() == ExitCode::kStore;
    const std::optional<Leave> leave = control_.asked(signals_);
    if (!leave || !word_wins(*leave, met)) {
      error_ = met;
      return;
    }
    heard_ = leave->word;
    met_ = met;
    error_ = with_fault(error_of(*leave, where), met);
  }
}

void Ending::by(const Error& error) {
  if (!error_) error_ = error;
}

void Ending::hear_last_words(const std::string& where) {
  const std::optional<Leave> leave = control_.close(signals_);
  if (!leave || leave->word == heard_) return;
  const Error word = error_of(*leave, where);
  if (!error_ && leave->word != Word::kStop) {
    error_ = word;
  } else {
    last_word_ = word;
  }
}

db::Outcome Ending::outcome() const {
  if (!error_) return db::Outcome::kCompleted;
  if (error_->id() == "TB-RUN-STOPPED") return db::Outcome::kStopped;
  const bool by_word = error_->id() == "TB-RUN-ABORTED" || error_->id() == "TB-RUN-PANIC";
  return by_word || error_->code() == ExitCode::kStopped ? db::Outcome::kAborted : db::Outcome::kFailed;
}

void Ending::write(Recorder& recorder) const {
  if (met_) recorder.event("fault", met_->id(), met_->what());
  if (error_) recorder.event("fault", error_->id(), error_->what());
  if (last_word_) recorder.event("word", last_word_->id(), last_word_->what());
}

}  // namespace tactbench::bench
