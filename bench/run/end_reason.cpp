#include "bench/run/end_reason.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/pressure_unit.h"

namespace tactbench::bench {
namespace {

Error error_of(const RunEndRequested& leave, const std::string& where) {
  if (leave.command != Command::kStop) {
    const bool panic = leave.command == Command::kPanic;
    return Error(panic ? ErrorId("TB-RUN-PANIC") : ErrorId("TB-RUN-ABORTED"),
                 fmt::format("{} by {}", panic ? "panic" : "aborted", leave.who), where)
        .by_command();
  }
  return Error("TB-RUN-STOPPED", "stopped by " + leave.who, where).by_signal(leave.signal).by_command();
}

bool command_wins(const RunEndRequested& leave, const Error& met) {
  return leave.command == Command::kPanic || met.code() == ExitCode::kDevice;
}

// 7 outranks all other exit codes.
Error with_fault(const Error& word, const Error& met) {
  return word.with_message(fmt::format("{}; also, while the run ended: {}", word.what(), met.id()))
      .with_rig_state(word.rig_state(), met.code() != ExitCode::kUnsafe);
}

}  // namespace

void EndReason::by_exception(const std::string& where) {
  try {
    throw;
  } catch (const RunEndRequested& leave) {
    heard_ = leave.command;
    error_ = error_of(leave, where);
  } catch (...) {
    const Error met = as_error(std::current_exception(), where);
    store_failed_ = store_failed_ || met.code() == ExitCode::kStore;
    const std::optional<RunEndRequested> leave = control_.asked(signals_);
    if (!leave || !command_wins(*leave, met)) {
      heard_.reset();
      error_ = met;
      return;
    }
    heard_ = leave->command;
    met_ = met;
    error_ = with_fault(error_of(*leave, where), met);
  }
}

void EndReason::by(const Error& error) {
  if (!error_) error_ = error;
}

void EndReason::record_last_command(const std::string& where) {
  const std::optional<RunEndRequested> leave = control_.close(signals_);
  if (!leave || leave->command == heard_) return;
  const Error word = error_of(*leave, where);
  if (!error_ && leave->command != Command::kStop) {
    heard_ = leave->command;
    error_ = word;
  } else {
    last_command_ = word;
  }
}

db::Outcome EndReason::outcome() const {
  if (!error_) return db::Outcome::kCompleted;
  if (heard_) return *heard_ == Command::kStop ? db::Outcome::kStopped : db::Outcome::kAborted;
  return error_->code() == ExitCode::kStopped ? db::Outcome::kAborted : db::Outcome::kFailed;
}

void EndReason::write(Recorder& recorder) const {
  if (met_) recorder.event("fault", met_->id(), met_->what());
  if (error_) recorder.event("fault", error_->id(), error_->what());
  if (last_command_) recorder.event("word", last_command_->id(), last_command_->what());
}

using sequences::Recipe;
using sequences::Step;
using sequences::StepKind;

namespace {

std::string conditioning_text(const Step& step, const Recipe& recipe) {
  const bool by_criterion = recipe.conditioning.change_percent > 0.0;
  // A recipe without conditioning cycles is conditioned once before a branch is repeated.
  const int cycles = std::max(1, recipe.conditioning.cycles);
  return fmt::format("conditioning {} of {}{}", step.repeat + 1, by_criterion ? "at most " : "", cycles);
}

// With a frame: where the run is in its plan.
std::string level_text(const Step& step, const Recipe& recipe, int number, int steps, bool rising) {
  std::string text = fmt::format("{}, step {} of {}", recipe.name, number, steps);
  if (recipe.repeats > 1) text += fmt::format(", repeat {} of {}", step.repeat + 1, recipe.repeats);
  return text + (rising ? ", loading" : ", unloading");
}

}  // namespace

std::string phase_of(const Step& step, const Recipe& recipe, int number, int steps) {
  if (step.branch < 0) return conditioning_text(step, recipe);
  switch (step.kind) {
    case StepKind::kConditioning:
      return "travelling to " + analysis::both_units(step.setpoint.value());
    case StepKind::kMeasure:
      return level_text(step, recipe, number, steps, step.branch_to > step.branch_from);
    case StepKind::kPrompt:
      return "asking: " + step.text;
    case StepKind::kTare:
      return "zeroing the force sensor";
    case StepKind::kHome:
      return "homing the stage";
    case StepKind::kMoveXy:
      return fmt::format("moving to x {:g} mm, y {:g} mm", step.x_mm, step.y_mm);
    case StepKind::kApproach:
      return "approaching the specimen";
    case StepKind::kPress:
      if (!step.frame) return fmt::format("pressing to {:g} N", step.force_n);
      return level_text(step, recipe, number, steps, step.force_to_n >= step.force_from_n);
    case StepKind::kRetract:
      return "retracting the stage";
  }
  return {};
}

}  // namespace tactbench::bench
