// The conductor's waits, for a person or a condition. Meanwhile the rig is vented and proved safe.
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/run/conductor.h"
#include "devices/fault.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;

namespace {

constexpr const char* kByTerminal = "the operator";

bool line_typed() {
  bool ended = false;
  char byte = 0;
  for (pollfd input{STDIN_FILENO, POLLIN, 0};
       !ended && ::poll(&input, 1, 0) == 1 && ::read(STDIN_FILENO, &byte, 1) == 1;)
    ended = byte == '\n';
  return ended;
}

std::string answered_words(const GivenAnswer& answer, const std::string& question) {
  if (answer.who == kByTerminal) return "the operator has answered: " + question;
  if (answer.text.empty()) return fmt::format("answered by {}: {}", answer.who, question);
  return fmt::format("answered by {}, \"{}\": {}", answer.who, answer.text, question);
}

}  // namespace

void Conductor::pause(const std::string& why) {
  if (recorder_.state() == RunState::kRunning) set_state(RunState::kPausing, why);
  vent("to pause");
  status_.phase = "paused, vented: waits for `tactbench resume`";
  set_state(RunState::kPaused, why);
  board_.note(fmt::format("run {} is paused, vented: `tactbench resume {}` continues, `tactbench stop {}` ends it",
                          status_.run, status_.run, status_.run));
  notify_.tell("waiting", status_.run, "paused: " + why);
  wait_for_resume();
}

void Conductor::wait_for_resume() {
  (void)sequencer_.times().start(Spent::kWaiting);
  const Nanoseconds start = sequencer_.rig().clock().now();
  do sequencer_.idle();  // at least once: the clock runs while a person decides
  while (!control_.take_resume());
  rested_s_ = devices::in_seconds(sequencer_.rig().clock().now() - start);
  recover();
  set_state(RunState::kRunning, fmt::format("resumed by {} after {:.0f} s", control_.who(), rested_s_));
  displaced_ = true;
}

// As for a resumed run (resume.h): all branches of a repeat must share one loading history.
std::size_t Conductor::after_rest(std::size_t next) {
  if (next == spans_.size() || spans_[next].kind != sequences::SpanKind::kBranch) return next;
  const sequences::BranchKey key = spans_[next].key;
  if (rested_s_ <= work_.recipes[static_cast<std::size_t>(key.sequence)].rest_restart_s) return next;
  const auto same = [&](const sequences::BranchKey& other) {
    return other.sequence == key.sequence && other.repeat == key.repeat;
  };
  recorder_.void_repeat(key.sequence, key.repeat,
                        fmt::format("the sensor rested for {:.0f} s: the repeat is done again", rested_s_));
  std::erase_if(work_.done, same);
  const auto first = std::find_if(spans_.begin(), spans_.end(), [&](const sequences::BranchSpan& span) {
    return span.kind == sequences::SpanKind::kBranch && same(span.key);
  });
  return static_cast<std::size_t>(first - spans_.begin());
}

// Another program has locked the store, so no step may follow: what was measured last is not kept yet. A short lock is
// waited for where the work stands, with the module fed and the pressures watched; for a longer one the run is
// suspended like one without supply. Outside of the work the rig is vented or on its way there, which goes on.
bool Conductor::bear_lock(const db::StoreError& locked, double waited_s) {
  constexpr double kStands = 5.0, kLongest = 3600.0;  // s
  const RunState state = recorder_.state();
  if (!working_ || (state != RunState::kRunning && state != RunState::kPausing)) return false;
  if (waited_s > kStands) throw Suspended{locked.what(), kLongest};
  working_ = false;  // what is recorded meanwhile waits behind; what is thrown ends the work
  sequencer_.stand();
  working_ = true;
  return true;
}

void Conductor::suspend(const Suspended& suspended) {
  set_state(RunState::kSuspended, suspended.what);
  vent("to wait: " + suspended.what);
  status_.phase = "waiting, vented: " + suspended.what;
  publish();
  board_.note(fmt::format("run {} waits, vented: {}", status_.run, suspended.what));
  notify_.tell("waiting", status_.run, suspended.what);
  (void)sequencer_.times().start(Spent::kWaiting);
  Rig& rig = sequencer_.rig();
  const Nanoseconds start = rig.clock().now();
  const Nanoseconds deadline = start + seconds(suspended.timeout_s);
  SuspensionWatch watch = sequencer_.conditions();
  while (!recorder_.flush() || !watch.may_resume(rig.environment(), rig.clock().now())) {
    if (rig.clock().now() > deadline) {
      if (!recorder_.flush()) throw db::StoreError(*recorder_.locked());
      throw Fault("TB-RUN-SUSPENDED", "surroundings",
                  fmt::format("{}, and it did not come back within {:g} s", suspended.what, suspended.timeout_s));
    }
    sequencer_.idle();
  }
  rested_s_ = devices::in_seconds(rig.clock().now() - start);
  recover();
  set_state(RunState::kRunning, "what was waited for is there again");
  displaced_ = true;
}

void Conductor::prompt(const sequences::Step& step) {
  if (work_.assume_yes) {
    recorder_.event("prompt", "", step.text + " (answered by --yes)");
    return;
  }
  vent("for the operator");
  status_.question = step.text;
  const int question = ++status_.question_id;
  status_.phase = "waiting for an answer: " + step.text;
  const bool terminal = isatty(STDIN_FILENO) == 1;
  // What was typed before the question is no answer to it.
  if (terminal) (void)::tcflush(STDIN_FILENO, TCIFLUSH);
  if (recorder_.state() == RunState::kRunning) set_state(RunState::kPausing, "for the operator");
  set_state(RunState::kPaused, "operator: " + step.text);
  board_.note(fmt::format("{}\n  when done: {}`tactbench resume {}`", step.text, terminal ? "press Enter, or " : "",
                          status_.run));
  notify_.tell("waiting", status_.run, step.text);
  (void)sequencer_.times().start(Spent::kWaiting);
  std::optional<GivenAnswer> answer;
  while (!answer) {
    sequencer_.idle();
    (void)control_.take_resume();  // an answer, too
    if (terminal && line_typed()) {
      const Control::Answer told = control_.answer(question, {}, kByTerminal);
      if (!told.taken) board_.note(told.text);
    }
    answer = control_.answer_to(question);
  }
  if (answer->who != kByTerminal)
    board_.note(fmt::format("answered by {}{}{}", answer->who, answer->text.empty() ? "" : ": ", answer->text));
  status_.question.clear();
  recover();
  set_state(RunState::kRunning, answered_words(*answer, step.text));
}

bool Conductor::vented(const std::string& why) {
  status_.phase = "venting " + why;
  status_.target_n.reset();
  publish();
  const SafeProof proof = make_safe(sequencer_.rig(), baseline_);
  recorder_.event("safe", to_string(proof.state), why + ": " + proof.text.in(analysis::PressureUnit::kPsi));
  sequencer_.forget();
  stage_.forget();
  return proof.state == db::SafeState::kVerified;
}

void Conductor::vent(const std::string& why) {
  if (vented(why)) return;
  throw Error("TB-SAFE-UNVERIFIED", "the safe state could not be proved " + why, fmt::format("run {}", status_.run));
}

void Conductor::recover() {
  Rig& rig = sequencer_.rig();
  for (const Nanoseconds end = rig.clock().now() + std::chrono::hours(1); !recorder_.flush(); sequencer_.idle()) {
    if (rig.clock().now() > end) throw db::StoreError(*recorder_.locked());
    status_.phase = fmt::format("waiting, vented: {}", recorder_.locked()->what());
    publish();
  }
  status_.phase = "opening the devices again";
  publish();
  rig.source().arm();
  rig.close_array();
  rig.open_array();
}

bool Conductor::recovered() try {
  recover();
  return true;
} catch (const Fault& fault) {
  recorder_.event("attempt", fault.id(), fmt::format("the devices do not come back: {}", fault.what()));
  return false;
}

}  // namespace tactbench::bench
