#include "bench/run/conductor.h"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/run/end_reason.h"
#include "bench/run/recorder.h"
#include "bench/run/watch/watches.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Fault;
using sequences::BranchKey;
using sequences::BranchSpan;
using sequences::Recipe;
using sequences::SpanKind;
using sequences::Step;
using sequences::StepKind;

namespace {

class During {
 public:
  explicit During(bool& flag) : flag_(flag), before_(std::exchange(flag, true)) {}
  ~During() { flag_ = before_; }
  During(const During&) = delete;
  During& operator=(const During&) = delete;

 private:
  bool& flag_;
  bool before_;
};

}  // namespace

Conductor::Conductor(Sequencer& sequencer, Recorder& recorder, Control& control, StatusBoard& board,
                     const Notify& notify, Work work, UnloadedFrame baseline)
    : sequencer_(sequencer),
      recorder_(recorder),
      control_(control),
      board_(board),
      notify_(notify),
      work_(std::move(work)),
      baseline_(std::move(baseline)),
      status_(board.now()),
      frames_before_(board.now().frames + board.now().frames_void),
      stage_(sequencer, recorder),
      spans_(sequences::branches(work_.steps)) {
  sequencer_.set_listener([this] { listen(); });
  recorder_.when_locked(
      [this](const db::StoreError& locked, double waited_s) { return handle_store_lock(locked, waited_s); });
  status_.steps = static_cast<int>(work_.steps.size());
  status_.frames_planned = std::ranges::count_if(work_.steps, sequences::has_frame);
  publish();
}

void Conductor::run() {
  std::size_t i = first_span();
  while (i < spans_.size()) {
    const BranchSpan& span = spans_[i];
    sequencer_.follow(work_.recipes[static_cast<std::size_t>(span.key.sequence)]);
    status_.step = static_cast<int>(span.first);
    try {
      if (span.kind == SpanKind::kBranch) {
        if (!work_.done.contains(span.key)) branch(span);
      } else if (span.kind == SpanKind::kConditioning) {
        conditioning(span);
      } else {
        travel(span);
      }
    } catch (const Suspended& suspended) {  // the branch or the step before it is repeated
      suspend(suspended);
      i = after_rest(i);
      continue;
    }
    ++i;
    if (control_.pause_wanted()) {
      pause("asked by " + control_.who());
      i = after_rest(i);
    }
  }
}

void Conductor::run_through_suspensions(const std::function<void()>& work) {
  for (;;) {
    try {
      const During working(working_);
      return work();
    } catch (const Suspended& suspended) {
      suspend(suspended);
    }
  }
}

// Continues at the first branch that is not done: from the steps before it where its sequence has not begun, else by
// the path to its start.
std::size_t Conductor::first_span() {
  if (work_.done.empty()) return 0;
  std::size_t after_done = 0;
  for (std::size_t i = 0; i < spans_.size(); ++i) {
    if (spans_[i].kind != SpanKind::kBranch) continue;
    if (work_.done.contains(spans_[i].key)) {
      after_done = i + 1;
      continue;
    }
    const int sequence = spans_[i].key.sequence;
    const bool begun = std::any_of(work_.done.begin(), work_.done.end(),
                                   [&](const BranchKey& key) { return key.sequence == sequence; });
    if (!begun) return after_done;
    displaced_ = true;
    return i;
  }
  return spans_.size();
}

void Conductor::branch(const BranchSpan& span) {
  const Recipe& recipe = work_.recipes[static_cast<std::size_t>(span.key.sequence)];
  int broken = 0, failed = 0;
  for (;;) {
    const bool tolerant = broken == recipe.guard.redo && !recipe.guard.fail_when_broken;
    try {
      attempt(span, tolerant);
      return;
    } catch (const PathBroken& path) {
      const std::string what = fmt::format("branch {} of repeat {}: {}", span.key.branch, span.key.repeat, path.what);
      recorder_.event("branch-broken", "TB-BRANCH-BROKEN", what);
      give_up("TB-BRANCH-BROKEN: " + path.what);
      if (broken++ >= recipe.guard.redo) {
        throw Fault("TB-BRANCH-BROKEN", "sequencer", fmt::format("{}, {}", what, analysis::counted(broken, "time")));
      }
    } catch (const Suspended& suspended) {
      give_up("suspended: " + suspended.what);
      ++redone_;
      throw;
    } catch (const Fault& fault) {
      const bool by_device = as_error(std::current_exception()).code() == ExitCode::kDevice;
      // No further attempt once the end was asked for; after a panic the panic itself may have caused the fault.
      if (!by_device || sequencer_.leaving() || failed++ >= recipe.retry.branch) throw;
      recorder_.event("attempt", fault.id(),
                      fmt::format("branch {} of repeat {}, {} of {}: {}", span.key.branch, span.key.repeat, failed,
                                  recipe.retry.branch + 1, fault.what()));
      give_up(fault.id() + ": " + fault.what());
      // The first fault is the reason; the way out tries again to reach the safe state.
      if (!vented("after a fault") || !recovered()) throw;
    }
    ++redone_;
  }
}

void Conductor::attempt(const BranchSpan& span, bool tolerant) {
  const During working(working_);
  const Step& first = work_.steps[span.first];
  if (displaced_) go_back(span.key);
  displaced_ = false;
  recorder_.open_branch(first);
  sequencer_.begin_branch(first, tolerant);
  for (std::size_t i = span.first; i < span.first + span.count; ++i) {
    status_.step = static_cast<int>(i) + 1;
    carry_out(work_.steps[i]);
    fail_fast(work_.steps[i]);
  }
  sequencer_.end_branch();
  recorder_.close_branch();
}

void Conductor::go_back(const BranchKey& key) {
  const Recipe& recipe = work_.recipes[static_cast<std::size_t>(key.sequence)];
  recorder_.event(
      "way-back", "",
      fmt::format("conditioned again, then the turning points before branch {} of repeat {}", key.branch, key.repeat));
  const TimeSpent::Stretch stretch(sequencer_.times(), Spent::kRedoing);
  const std::string back = fmt::format("back to branch {} of repeat {}: ", key.branch + 1, key.repeat + 1);
  for (const Step& step : sequences::path_to_branch(recipe, key.sequence, key.repeat, key.branch))
    carry_out(step, back);
}

void Conductor::conditioning(const BranchSpan& span) {
  displaced_ = false;  // these steps are the path back themselves
  while (!condition(span)) pause("asked by " + control_.who());
}

// Runs all cycles from the first; false when a pause was asked for meanwhile.
bool Conductor::condition(const BranchSpan& span) {
  const During working(working_);
  const Recipe& recipe = work_.recipes[static_cast<std::size_t>(span.key.sequence)];
  ConditioningWatch watch(recipe.conditioning);
  const TimeSpent::Stretch stretch(sequencer_.times(), Spent::kConditioning);
  for (std::size_t i = span.first; i < span.first + span.count; ++i) {
    status_.step = static_cast<int>(i) + 1;
    if (watch.enough(work_.steps[i].repeat)) break;
    carry_out(work_.steps[i]);
    std::string flags;
    if (watch.wants_output()) watch.see(work_.steps[i], sequencer_.read_array(flags).counts);
    if (control_.pause_wanted()) return false;
  }
  recorder_.check("conditioning", watch.verdict(), watch.detail_json(), watch.changes());
  return true;
}

void Conductor::travel(const BranchSpan& span) {
  const During working(working_);
  for (std::size_t i = span.first; i < span.first + span.count; ++i) carry_out(work_.steps[i]);
}

void Conductor::carry_out(const Step& step, const std::string& before) {
  const Recipe& recipe = work_.recipes[static_cast<std::size_t>(step.sequence)];
  status_.phase = before + phase_of(step, recipe, status_.step, status_.steps);
  status_.target_n = step.kind == StepKind::kPress ? std::optional(step.force_n) : std::nullopt;
  publish();
  if (work_.on_step) work_.on_step(step);
  sequencer_.begin_step();
  if (step.kind == StepKind::kPrompt) {
    prompt(step);
  } else if (step.kind == StepKind::kConditioning || step.kind == StepKind::kMeasure) {
    sequencer_.chamber_step(step);
  } else {
    stage_.carry_out(step, recipe);
  }
  board_.step_done();
}

// Checked once, at the first frame at the recipe's highest level.
void Conductor::fail_fast(const Step& step) {
  const Recipe& recipe = work_.recipes[static_cast<std::size_t>(step.sequence)];
  const sequences::FailFast& limits = recipe.limits;
  if (peak_seen_ || step.kind != StepKind::kMeasure || baseline_.empty()) return;
  if (limits.least_response_v <= 0.0 && limits.most_dead_taxels < 0) return;
  if (step.setpoint < *std::max_element(recipe.turning_points.begin(), recipe.turning_points.end())) return;
  peak_seen_ = true;
  const double volts = sequencer_.rig().array().volts_per_count().value();
  constexpr double kDeadVolts = 0.05;
  const UnloadedFrame now = unloaded_frame_of(sequencer_.last().scans);
  double sum = 0.0;
  int dead = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double rise = (now[i] - baseline_[i]) * volts;
    sum += rise;
    dead += rise < kDeadVolts ? 1 : 0;
  }
  const double mean = sum / static_cast<double>(now.size());
  const bool weak = mean < limits.least_response_v;
  if (!weak && (limits.most_dead_taxels < 0 || dead <= limits.most_dead_taxels)) return;
  throw Error("TB-RUN-HOPELESS",
              fmt::format("at the first {} the array responds with {:.3f} V on average, and {} not at all",
                          analysis::both_units(step.setpoint.value()), mean, analysis::counted(dead, "taxel")),
              fmt::format("recipe '{}' [limits]", recipe.name));
}

void Conductor::give_up(const std::string& reason) {
  sequencer_.end_branch();
  recorder_.void_branch(reason);
  displaced_ = true;
}

void Conductor::set_state(RunState state, const std::string& reason) {
  recorder_.state(state, reason);
  status_.state = state;
  status_.reason = reason;
  publish();
}

// Shows immediately that a pause was requested or revoked.
void Conductor::listen() {
  if (work_.on_poll) work_.on_poll();
  record_notices(sequencer_.rig(), recorder_, board_.progress());
  check_dead_man(sequencer_.rig());
  if (control_.pause_wanted() && recorder_.state() == RunState::kRunning) {
    set_state(RunState::kPausing, "asked by " + control_.who());
    board_.note("pausing at the end of this branch; Ctrl-C (or `tactbench stop`) ends the run now");
  } else if (!control_.pause_wanted() && recorder_.state() == RunState::kPausing) {
    (void)control_.consume_resume();
    set_state(RunState::kRunning, "revoked by " + control_.who());
  }
  // The stage's steps poll no pressure; while a person is waited for, the note on the terminal is kept.
  if (status_.target_n) sequencer_.publish_readings();
  if (recorder_.state() == RunState::kRunning || recorder_.state() == RunState::kPausing) board_.refresh();
}

void Conductor::publish() {
  if (work_.estimate != nullptr) {
    const TimeBand left = work_.estimate->remaining(static_cast<std::size_t>(status_.step));
    status_.left_s = left.p50_s;
    status_.left_low_s = left.p10_s;
    status_.left_high_s = left.p90_s;
    status_.prompts_left = work_.assume_yes ? 0 : left.prompts;
  }
  status_.frames_void = recorder_.void_frames();
  status_.frames = frames_before_ + recorder_.frames() - status_.frames_void;
  board_.publish();
}

// The conductor's waits, for a person or a condition. Meanwhile the rig is vented and proved safe.

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

std::string answered_text(const GivenAnswer& answer, const std::string& question) {
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
  notify_.run_command("waiting", status_.run, "paused: " + why);
  wait_for_resume();
}

void Conductor::wait_for_resume() {
  (void)sequencer_.times().start(Spent::kWaiting);
  const Nanoseconds start = sequencer_.rig().clock().now();
  do sequencer_.idle();  // at least once: the clock runs while a person decides
  while (!control_.consume_resume());
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
  recorder_.void_repeat(
      key.sequence, key.repeat,
      fmt::format("the sensor rested for {:.0f} s: the repeat is repeated from its start", rested_s_));
  std::erase_if(work_.done, same);
  const auto first = std::find_if(spans_.begin(), spans_.end(), [&](const sequences::BranchSpan& span) {
    return span.kind == sequences::SpanKind::kBranch && same(span.key);
  });
  return static_cast<std::size_t>(first - spans_.begin());
}

// Another program has locked the store, so no step may follow: what was measured last is not kept yet. During a short
// lock the run holds its present state, feeding the module and monitoring the pressures; during a longer one it is
// suspended, as without supply. Outside of the work the rig is vented or being vented, which continues.
bool Conductor::handle_store_lock(const db::StoreError& locked, double waited_s) {
  constexpr double kStands = 5.0, kLongest = 3600.0;  // s
  const RunState state = recorder_.state();
  if (!working_ || (state != RunState::kRunning && state != RunState::kPausing)) return false;
  if (waited_s > kStands) throw Suspended{locked.what(), kLongest};
  working_ = false;  // new records are queued; an exception ends the work
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
  notify_.run_command("waiting", status_.run, suspended.what);
  (void)sequencer_.times().start(Spent::kWaiting);
  Rig& rig = sequencer_.rig();
  const Nanoseconds start = rig.clock().now();
  const Nanoseconds deadline = start + seconds(suspended.timeout_s);
  SuspensionWatch watch = sequencer_.conditions();
  while (!recorder_.flush() || !watch.may_resume(rig.environment(), rig.clock().now())) {
    if (rig.clock().now() > deadline) {
      if (!recorder_.flush()) throw db::StoreError(*recorder_.locked());
      throw Fault("TB-RUN-SUSPENDED", "surroundings",
                  fmt::format("{}, and it did not recover within {:g} s", suspended.what, suspended.timeout_s));
    }
    sequencer_.idle();
  }
  rested_s_ = devices::in_seconds(rig.clock().now() - start);
  recover();
  set_state(RunState::kRunning, "the condition is met again");
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
  // Text typed before the question is not an answer to it.
  if (terminal) (void)::tcflush(STDIN_FILENO, TCIFLUSH);
  if (recorder_.state() == RunState::kRunning) set_state(RunState::kPausing, "for the operator");
  set_state(RunState::kPaused, "operator: " + step.text);
  board_.note(fmt::format("{}\n  when done: {}`tactbench resume {}`", step.text, terminal ? "press Enter, or " : "",
                          status_.run));
  notify_.run_command("waiting", status_.run, step.text);
  (void)sequencer_.times().start(Spent::kWaiting);
  std::optional<GivenAnswer> answer;
  while (!answer) {
    sequencer_.idle();
    (void)control_.consume_resume();  // an answer, too
    if (terminal && line_typed()) {
      const Control::Answer reply = control_.answer(question, {}, kByTerminal);
      if (!reply.taken) board_.note(reply.text);
    }
    answer = control_.answer_to(question);
  }
  if (answer->who != kByTerminal)
    board_.note(fmt::format("answered by {}{}{}", answer->who, answer->text.empty() ? "" : ": ", answer->text));
  status_.question.clear();
  recover();
  set_state(RunState::kRunning, answered_text(*answer, step.text));
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
  recorder_.event("attempt", fault.id(), fmt::format("the devices cannot be reopened: {}", fault.what()));
  return false;
}

}  // namespace tactbench::bench
