#include "bench/run/sequencer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "analysis/pressure_unit.h"
#include "bench/common/process_time.h"
#include "bench/safety/ramp.h"
#include "db/record.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;
using devices::Psi;
using sequences::Step;

namespace {

constexpr double kConditionsEvery = 5.0;  // s of process time between two readings of the surroundings

}  // namespace

void Sequencer::follow(const sequences::Recipe& recipe) {
  recipe_ = &recipe;
  suspension_.follow(recipe.suspend);
}

UnloadedFrame Sequencer::read_unloaded_frame() {
  poll();
  // Until both can be true; poll() throws when that lasts.
  while (!rig_.guard().feedback().possible() || !rig_.guard().reference().possible()) {
    wait_until(rig_.clock().now() + seconds(0.2));
    poll();
  }
  const double highest = std::max(readings_.feedback.pressure.value(), readings_.reference.pressure.value());
  if (highest >= rig_.config().limits.safe_psi) {
    throw Fault("TB-CHAMBER-NOT-VENTED", "chamber",
                fmt::format("the chamber holds {} before the first command", analysis::both_units(highest, 1)));
  }
  std::string flags;
  return unloaded_frame_of(read_array(flags));
}

void Sequencer::begin_branch(const Step& first, bool tolerant) {
  tolerant_ = tolerant;
  broken_ = false;
  watch_path(first.branch_from, first.branch_to);
}

void Sequencer::watch_path(Psi from, Psi to) {
  guard_.emplace(from.value(), to.value(), recipe_->guard.tolerance.value());
}

void Sequencer::begin_step() {
  step_deadline_ =
      recipe_->step_timeout_s > 0.0 ? rig_.clock().now() + seconds(recipe_->step_timeout_s) : Nanoseconds::max();
}

void Sequencer::chamber_step(const Step& step) {
  const std::uint64_t exchanges_before = rig_.exchanges();
  readings_.flags.clear();
  left_band_ = false;
  if (!rig_.source().armed()) {  // the stage was in use
    rig_.source().arm();
    setpoint_ = Psi(0.0);
  }
  moving_ = !step.hold;
  // A branch's first level may be reached from the other side: up to the 60 psi from which a branch falls.
  const bool turns_first = guard_ && moving_ && step.setpoint == step.branch_from && step.setpoint != setpoint_ &&
                           (step.setpoint > setpoint_) != (step.branch_to > step.branch_from);
  if (turns_first) watch_path(setpoint_, step.setpoint);
  if (!step.hold) ramp(step);
  if (step.settle && !step.hold) settle(step);
  if (turns_first) watch_path(step.branch_from, step.branch_to);
  (void)times_.start(Spent::kDwelling);
  moving_ = false;
  dwell(step);
  if (!sequences::has_frame(step)) return;
  (void)times_.start(Spent::kReading);
  std::string retried;
  readings_.scans = read_array(retried);
  check_array();
  if (db::scans_disagree(readings_.scans.counts, static_cast<std::size_t>(readings_.scans.scans))) add_flag("outlier");
  last_frame_ = readings_.scans.time;
  readings_.exchanges = static_cast<int>(rig_.exchanges() - exchanges_before);
  const double dwelt = devices::in_seconds(readings_.scans.time - readings_.in_band_since);
  const bool dwells = step.settle && !step.hold;
  if (dwells && std::abs(dwelt - step.dwell_s) > recipe_->dwell_tolerance_s) add_flag("dwell");
  if (left_band_) add_flag("left-band");
  if (broken_) add_flag("broken");
  if (!retried.empty()) add_flag(retried);
  recorder_.frame(step, readings_);
}

void Sequencer::check_array() {
  constexpr double kFollows = 1.0;  // psi of pressure change after which a connected row must have changed
  const StuckRows stuck = stuck_rows_.see(readings_.scans, readings_.reference.pressure.value(), kFollows);
  if (stuck.all) {
    throw Fault("TB-SCANNER-STALE", "tactile scanner",
                fmt::format("the frame at {} is identical, bit for bit, to the previous one at another pressure",
                            analysis::both_units(readings_.reference.pressure.value(), 1)));
  }
  if (!stuck.rows.empty()) add_flag("row-stuck");
}

void Sequencer::add_flag(const std::string& flag) {
  if (!readings_.flags.empty()) readings_.flags += ' ';
  readings_.flags += flag;
}

// The set-point moves in ticks at a limited rate; a small step is one tick. Where frames are read during the ramp, the
// pressure follows it and does not settle.
void Sequencer::ramp(const Step& step) {
  (void)times_.start(Spent::kMoving);
  const SafetyLimits& limits = rig_.config().limits;
  const double rate =
      step.ramp_psi_per_s > 0.0 ? std::min(step.ramp_psi_per_s, limits.rate_psi_per_s) : limits.rate_psi_per_s;
  readings_.commanded_at = readings_.in_band_since = rig_.clock().now();
  RampHooks hooks;
  hooks.before = [&](const RampTick& tick) {
    // The last tick of a long ramp starts from rest: its overshoot is then that of a small step.
    const bool lands = tick.last && !tick.first && step.settle;
    if (lands) wait_until(rig_.clock().now() + seconds(rig_.config().settling.landing_s));
    if (rig_.clock().now() - polled_ > seconds(0.5 * limits.stale_s)) poll();  // the guard requires fresh readings
  };
  hooks.after = [&](const RampTick& tick) {
    if (tick.last && step.settle) return;
    wait_until(rig_.clock().now() + seconds(tick.seconds));
    poll();
  };
  readings_.setpoint_counts = ramp_to(rig_, step.setpoint, setpoint_, ramp_tick_psi(limits, rate), hooks);
}

void Sequencer::settle(const Step& step) {
  (void)times_.start(Spent::kSettling);
  const Settling& settling = rig_.config().settling;
  devices::Clock& clock = rig_.clock();
  const Nanoseconds start = clock.now();
  const Nanoseconds deadline = start + seconds(settling.timeout_s);
  const Nanoseconds feed = rig_.config().regulator.feed_interval;
  // The first reading comes with the first feeding, then a few quick ones while a small step arrives; a long ramp is
  // read only as often as the module is fed, to save exchanges.
  constexpr int kQuickPolls = 4;
  double last_reference = std::numeric_limits<double>::infinity();
  for (int polls = 0;; ++polls) {
    const bool quick = polls > 0 && polls <= kQuickPolls;
    const Nanoseconds calm = settling.trace_s > 0.0 ? std::min(feed, seconds(settling.trace_s)) : feed;
    const Nanoseconds pause = quick ? seconds(settling.poll_s) : std::max(seconds(settling.poll_s), calm);
    const Nanoseconds before = clock.now();
    wait_until(before + pause);
    poll();
    const double reference = readings_.reference.pressure.value();
    const double slope = std::abs(reference - last_reference) / devices::in_seconds(clock.now() - before);
    last_reference = reference;
    const double miss = std::abs((readings_.feedback.pressure - step.setpoint).value());
    if (miss <= settling.band_psi && slope <= settling.slope_psi_per_s) break;
    if (clock.now() >= deadline) {
      throw Fault("TB-CHAMBER-TIMEOUT", "chamber",
                  fmt::format("chamber did not reach {} within {:g} s; last reading {} by the regulator, {} by the "
                              "reference, moving {} per second",
                              analysis::both_units(step.setpoint.value(), 1), settling.timeout_s,
                              analysis::both_units(readings_.feedback.pressure.value(), 2),
                              analysis::both_units(reference, 2), analysis::both_units(slope, 2)));
    }
  }
  readings_.in_band_since = clock.now();
}

void Sequencer::dwell(const Step& step) {
  const Settling& settling = rig_.config().settling;
  const Nanoseconds feed = rig_.config().regulator.feed_interval;
  const Nanoseconds every = settling.trace_s > 0.0 ? std::min(feed, seconds(settling.trace_s)) : feed;
  const Nanoseconds end = (step.hold ? last_frame_ : readings_.in_band_since) + seconds(step.dwell_s);
  Nanoseconds polled = rig_.clock().now();
  while (rig_.clock().now() < end) {
    wait_until(std::min({end, rig_.source().last_fed() + feed, polled + every}));
    poll();
    polled = rig_.clock().now();
    const double miss = std::abs((readings_.feedback.pressure - step.setpoint).value());
    left_band_ = left_band_ || (step.settle && miss > settling.band_psi);
  }
}

devices::ScanSet Sequencer::read_array(std::string& flags) {
  const int attempts = 1 + (recipe_ != nullptr ? recipe_->retry.frame : 0);
  for (int attempt = 1;; ++attempt) {
    try {
      return rig_.array().read(rig_.config().scans_per_frame);
    } catch (const Fault& fault) {
      recorder_.event("attempt", fault.id(), fmt::format("frame, {} of {}: {}", attempt, attempts, fault.what()));
      if (attempt >= attempts) throw;
      if (!recipe_->retry.any_passes) flags = "retried";
      wait_until(rig_.clock().now());
    }
  }
}

void Sequencer::poll() {
  rig_.source().keep_alive();
  polled_ = rig_.clock().now();
  readings_.feedback = rig_.source().feedback();
  readings_.reference = rig_.reference().read();
  recorder_.poll(setpoint_, readings_.feedback, readings_.reference);
  publish_readings();
  rig_.guard().check_witnesses();
  check_agreement();
  if (!guard_ || !rig_.guard().reference().possible()) return;
  const std::optional<std::string> broken = guard_->see(readings_.reference.pressure.value());
  if (broken && !tolerant_) throw PathBroken{*broken + " psi"};
  broken_ = broken_ || broken.has_value();
}

void Sequencer::publish_readings() {
  RunReadings now;
  now.time_s = recorder_.elapsed_s();
  now.setpoint_psi = setpoint_.value();
  now.feedback_psi = readings_.feedback.pressure.value();
  now.reference_psi = readings_.reference.pressure.value();
  now.settled = !moving_ && std::abs(now.feedback_psi - now.setpoint_psi) <= rig_.config().settling.band_psi;
  now.force_n = rig_.guard().last_force_n();
  control_.see(now);
}

// During a ramp the two may differ by their lag; a lasting difference means that one of them is wrong.
void Sequencer::check_agreement() {
  const SafetyLimits& limits = rig_.config().limits;
  const double apart = std::abs((readings_.feedback.pressure - readings_.reference.pressure).value());
  if (apart <= limits.disagreement_psi) {
    disagree_since_.reset();
    return;
  }
  const Nanoseconds now = rig_.clock().now();
  if (!disagree_since_) disagree_since_ = now;
  if (now - *disagree_since_ < seconds(limits.disagreement_s)) return;
  throw Fault("TB-CHAMBER-DISAGREE", "chamber",
              fmt::format("the regulator's feedback reads {} and the reference {}, apart for {:.1f} s",
                          analysis::both_units(readings_.feedback.pressure.value(), 2),
                          analysis::both_units(readings_.reference.pressure.value(), 2),
                          devices::in_seconds(now - *disagree_since_)),
              "check both against a hand gauge (`tactbench devices calibrate-reference`), the transducer's wiring and "
              "spans; the limits are [limits] disagreement_psi and disagreement_s");
}

void Sequencer::check_conditions() {
  if (suspension_.empty() || rig_.clock().now() < conditions_due_) return;
  conditions_due_ = rig_.clock().now() + seconds(kConditionsEvery);
  if (const std::optional<Suspended> suspended = suspension_.tripped(rig_.environment())) throw *suspended;
}

// The sequencer's waits: in slices, so that commands and signals are heard.

void Sequencer::poll_commands() {
  control_.poll(signals_);
  if (listener_) listener_();
}

void Sequencer::wait_until(Nanoseconds time) {
  devices::Clock& clock = rig_.clock();
  const double slice_s = pace_ > 0.0 ? 0.1 * pace_ : rig_.config().in_process ? 0.5 : 0.1 * rig_.config().rate;
  const Nanoseconds slice = seconds(slice_s);
  do {
    clock.wait_until(std::min(time, clock.now() + slice));
    if (pace_ > 0.0) keep_pace();
    poll_commands();
  } while (clock.now() < time);
  if (clock.now() > step_deadline_) {
    throw Fault("TB-STEP-TIMEOUT", "sequencer", fmt::format("a step took longer than {:g} s", recipe_->step_timeout_s));
  }
  check_conditions();
}

// Work that took longer than its time is not caught up.
void Sequencer::keep_pace() {
  const auto real = std::chrono::steady_clock::now();
  const Nanoseconds process = rig_.clock().now();
  const std::chrono::duration<double, std::nano> due(static_cast<double>((process - paced_at_).count()) / pace_);
  const auto until = paced_ + std::chrono::duration_cast<Nanoseconds>(due);
  if (until > real) std::this_thread::sleep_until(until);
  paced_ = std::max(until, real);
  paced_at_ = process;
}

void Sequencer::hold_vented(double duration_s) {
  Step rest;
  rest.dwell_s = duration_s;
  rest.settle = false;
  readings_.in_band_since = rig_.clock().now();
  dwell(rest);
}

namespace {
constexpr auto kTurn = std::chrono::milliseconds(200);
}

void Sequencer::stand() {
  step_deadline_ = Nanoseconds::max();
  if (rig_.config().in_process) {  // what is waited for takes real time, and nothing happens on this rig meanwhile
    std::this_thread::sleep_for(kTurn / 10);
    return poll_commands();
  }
  rig_.clock().wait_until(rig_.clock().now() + seconds(0.1 * rig_.config().rate));
  poll_commands();
  if (rig_.source().armed()) poll();
}

void Sequencer::idle() {
  step_deadline_ = Nanoseconds::max();
  // A manual clock does not wait, but a person needs real time.
  if (rig_.config().in_process) std::this_thread::sleep_for(kTurn / 10);
  const Nanoseconds end = rig_.clock().now() + kTurn;
  while (rig_.clock().now() < end) {
    rig_.clock().wait_until(std::min(end, rig_.clock().now() + seconds(0.1 * rig_.config().rate)));
    poll_commands();
  }
  poll();
}

}  // namespace tactbench::bench
