#include "bench/guard/guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/pressure_unit.h"
#include "bench/common/process_time.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Nanoseconds;
using devices::Psi;

namespace {

constexpr const char* kPressure = "pressure";
constexpr double kLoggedStepPsi = 1.0;
constexpr double kStepRounding = 1e-9;  // of a ramp's steps, relative
constexpr Nanoseconds kLongestDeadMan = std::chrono::seconds(15);

}  // namespace

GuardLimits guard_limits(const BenchConfig& config) {
  GuardLimits limits;
  limits.safety = config.limits;
  limits.safety.stale_s *= std::max(1.0, config.rate);
  limits.has_force = config.force.has_value();
  limits.feedback = feedback_range(config);
  limits.reference = reference_range(config);
  for (std::size_t i = 0; config.stage && i < limits.axes.size(); ++i) {
    const devices::AxisOptions& axis = config.stage->axis(i);
    limits.axes[i] = {axis.low.value(), axis.high.value(), axis.maximum_speed.value()};
  }
  return limits;
}

void Guard::set_actuators(devices::PressureSource* source, devices::Stage* stage) {
  source_ = source;
  stage_ = stage;
}

void Guard::feed() {
  if (watcher_ != nullptr) watcher_->feed();
}

void Guard::log(const std::string& actuator, const std::string& text, bool let_through) const {
  if (log_) log_(clock_.now(), actuator, text, let_through);
}

void Guard::refuse(const char* id, const char* actuator, const std::string& asked, const std::string& why,
                   const std::string& remedy) const {
  log(actuator, fmt::format("{}: {}", asked, why), false);
  throw devices::Fault(
      id, actuator, fmt::format("{} was requested and refused by the guard: {}; nothing was sent", asked, why), remedy);
}

void Guard::trip(const std::string& id, const std::string& what) noexcept {
  if (trip_) return;
  try {
    trip_ = Trip{id, what, run_, {}};
    vented_ = source_ != nullptr && source_->vent();
    if (source_ != nullptr) vented(vented_);
    // While the dead-man works, the stage's line belongs to it.
    const bool may_use_stage_line = id != kDeadManFired || watcher_ == nullptr || watcher_->wait_ended(Nanoseconds(0));
    halted_ = stage_ != nullptr && stage_used_ && may_use_stage_line && stage_->halt();
    log("guard", fmt::format("trip {}: {}", id, what), false);
    if (sink_) sink_(*trip_);
  } catch (...) {  // a recorder that fails must not stop a trip
  }
}

void Guard::reset(const std::string& who) {
  log("guard", fmt::format("reset by {}", who), true);
  trip_.reset();
  lost_.reset();
}

// Before any command: has the dead-man fired, or does it no longer watch?
void Guard::check_watcher() {
  if (trip_ || watcher_ == nullptr) return;
  if (watcher_->fired()) {
    trip(kDeadManFired, "the dead-man has fired: the sequencer was silent for too long, or a panic was commanded");
  } else if (const std::optional<WatcherLost> lost = watcher_->lost()) {
    lost_ = lost;
    trip(lost->id, lost->what);
  }
}

void Guard::check_open(const char* actuator, const std::string& asked, bool away) {
  check_watcher();
  if (!armed_) {
    refuse("TB-GUARD-NOT-ARMED", actuator, asked, "it is not armed", "Arm the pressure source or the stage first.");
  }
  if (trip_ && trip_->id == kDeadManFired) {
    refuse(kDeadManFired, actuator, asked, trip_->what,
           "Find out what delayed the sequencer; `tactbench devices reset` if the bench is tripped; start again.");
  }
  if (!trip_ || away) return;
  if (lost_) refuse(lost_->id.c_str(), actuator, asked, lost_->what, lost_->remedy);
  refuse("TB-GUARD-TRIPPED", actuator, asked, fmt::format("tripped ({}): {}", trip_->id, trip_->what),
         "Inspect the rig and find the cause, then `tactbench devices reset`.");
}

void Guard::check_fresh(const char* id, const char* actuator, const std::string& asked, const char* name,
                        Nanoseconds taken) const {
  const Nanoseconds age = clock_.now() - taken;
  if (taken >= Nanoseconds(0) && age <= seconds(limits_.safety.stale_s)) return;
  refuse(id, actuator, asked,
         taken < Nanoseconds(0) ? fmt::format("the {} has not been read", name)
                                : fmt::format("the last reading of the {} is {:.2f} s old, {:g} s are allowed", name,
                                              devices::in_seconds(age), limits_.safety.stale_s),
         "Read the instrument before loading; [limits] stale_s.");
}

void Guard::judge_pressure(const char* name, double psi) {
  if (!armed_ || trip_ || psi <= limits_.safety.trip_psi) return;  // NaN does not return here
  const std::string what = fmt::format("{} measured by the {}, above the trip of {}", analysis::both_units(psi, 1),
                                       name, analysis::both_units(limits_.safety.trip_psi, 1));
  trip("TB-CHAMBER-TRIP", what);
  throw devices::Fault("TB-CHAMBER-TRIP", "chamber",
                       what + (vented_ ? "; vented" : "; the module did NOT confirm the vent"));
}

void Guard::note_feedback(Psi pressure, Nanoseconds time) {
  feedback_.see(pressure.value(), time);
  reference_.see_other(feedback_);
  judge_pressure("regulator's feedback", pressure.value());
}

void Guard::note_reference(Psi pressure, Nanoseconds time) {
  reference_.see(pressure.value(), time);
  feedback_.see_other(reference_);
  judge_pressure("reference", pressure.value());
}

void Guard::note_force(const devices::Wrench& wrench, Nanoseconds time) {
  const auto& force = wrench.force_n;
  force_n_ = std::hypot(force[0], force[1], force[2]);
  force_time_ = time;
  if (!armed_ || trip_) return;
  for (std::size_t i = 0; i < force.size(); ++i) {
    if (std::abs(force[i]) <= limits_.safety.force_n[i]) continue;
    const std::string what = fmt::format("F{} = {:.2f} N measured, beyond the limit of {:g} N", "xyz"[i], force[i],
                                         limits_.safety.force_n[i]);
    trip("TB-FORCE-TRIP", what);
    throw devices::Fault("TB-FORCE-TRIP", "force sensor", what + halt_text());
  }
}

void Guard::check_witnesses() const {
  for (const auto& [name, witness] : {std::pair{"regulator's feedback", &feedback_}, {"reference", &reference_}}) {
    if (witness->impossible_s() < limits_.safety.disagreement_s) continue;
    throw devices::Fault(
        "TB-CHAMBER-WITNESS", "chamber",
        fmt::format("the {} reads {} for {:.1f} s, which {}", name, analysis::both_units(witness->psi(), 1),
                    witness->impossible_s(), witness->doubt()));
  }
}

void Guard::check_pressure(Psi pressure) {
  const double psi = pressure.value();
  const std::string asked = analysis::both_units(psi);
  check_open(kPressure, asked, false);
  if (!(psi >= 0.0 && psi <= limits_.safety.command_psi)) {
    refuse("TB-CHAMBER-LIMIT", kPressure, asked,
           "allowed is " + analysis::both_units_span(0.0, limits_.safety.command_psi),
           "Correct the recipe; [limits] command_psi is the chamber's limit.");
  }
  if (psi > setpoint_psi_) {
    for (const auto& [name, witness] : {std::pair{"regulator's feedback", &feedback_}, {"reference", &reference_}}) {
      check_fresh("TB-CHAMBER-STALE", kPressure, asked, name, witness->time());
      if (witness->ever_possible() && witness->impossible_s() < limits_.safety.disagreement_s) continue;
      refuse("TB-CHAMBER-WITNESS", kPressure, asked,
             fmt::format("the {} reads {}, which {}", name, analysis::both_units(witness->psi(), 1), witness->doubt()),
             "Check its supply and wiring, and its span in the bench file; then `tactbench devices check`.");
    }
    const Nanoseconds now = clock_.now();
    budget_psi_ = std::min(limits_.safety.step_psi,
                           budget_psi_ + limits_.safety.rate_psi_per_s * devices::in_seconds(now - budget_time_));
    budget_time_ = now;
    const double rise = psi - setpoint_psi_;
    if (rise > budget_psi_ + kStepRounding * limits_.safety.step_psi) {
      refuse(
          "TB-CHAMBER-RATE", kPressure, asked,
          fmt::format("the set-point is {} and may rise by {} now: {} at once, {:g} psi/s ({:.4g} kPa/s) continuously",
                      analysis::both_units(setpoint_psi_), analysis::both_units(budget_psi_),
                      analysis::both_units(limits_.safety.step_psi), limits_.safety.rate_psi_per_s,
                      devices::kilopascals(Psi(limits_.safety.rate_psi_per_s))),
          "Approach the level by a ramp; [limits] step_psi and rate_psi_per_s.");
    }
  }
  if (std::abs(psi - logged_psi_) < kLoggedStepPsi && (psi > 0.0 || logged_psi_ == 0.0)) return;
  logged_psi_ = psi;
  log(kPressure, asked, true);
}

void Guard::set_pressure(Psi pressure) {
  budget_psi_ -= std::max(0.0, pressure.value() - setpoint_psi_);
  setpoint_psi_ = pressure.value();
}

void Guard::source_armed() {
  setpoint_psi_ = 0.0;
  budget_psi_ = limits_.safety.step_psi;
  budget_time_ = clock_.now();
}

void Guard::stage_armed() {
  moving_.fill(false);
  stage_used_ = true;
  arm();
}

void Guard::vented(bool read_back) {
  if (read_back) setpoint_psi_ = 0.0;
  if (logged_psi_ != 0.0 || !read_back) log(kPressure, read_back ? "vent" : "vent, not read back", true);
  logged_psi_ = 0.0;
}

// Rewriting 0 psi is harmless; rewriting a pressure after a trip would undo the vent.
void Guard::check_rewriting() {
  if (setpoint_psi_ > 0.0) check_open(kPressure, "repeat of " + analysis::both_units(setpoint_psi_), false);
}

bool Guard::may_use_stage_line() {
  return watcher_ == nullptr || !watcher_->fired() || watcher_->wait_ended(kLongestDeadMan);
}

// The guard's rules for the stage.

using devices::Axis;

namespace {

constexpr const char* kNames[] = {"stage x", "stage y", "stage z"};
constexpr const char* kRecipe = "Correct the recipe; the limits in the bench file are those of the rig.";

const char* name(Axis axis) { return kNames[static_cast<std::size_t>(axis)]; }

}  // namespace

void Guard::check_move(Axis axis, double target_mm, double speed_mm_per_s, const ReadAxis& read) {
  const AxisLimits& limits = limits_.axes[static_cast<std::size_t>(axis)];
  const std::string asked = fmt::format("a move to {:g} mm at {:g} mm/s", target_mm, speed_mm_per_s);
  const bool in_range = target_mm >= limits.low_mm && target_mm <= limits.high_mm;
  if (!in_range || !(speed_mm_per_s > 0.0 && speed_mm_per_s <= limits.speed_mm_per_s)) {
    refuse("TB-STAGE-LIMIT", name(axis), asked,
           fmt::format("allowed is {:g} to {:g} mm at up to {:g} mm/s", limits.low_mm, limits.high_mm,
                       limits.speed_mm_per_s),
           kRecipe);
  }
  const bool deep = axis == Axis::kZ && target_mm > limits_.safety.clear_z_mm;
  const bool loads = deep && (trip_ || limits_.has_force || moving_[0] || moving_[1]);
  const bool away = axis == Axis::kZ && (trip_ || loads) && target_mm <= read(axis).position.value();
  check_open(name(axis), asked, away);
  if (loads && !away) {
    if (moving_[0] || moving_[1]) {
      refuse("TB-STAGE-ENVELOPE", name(axis), asked,
             fmt::format("x or y moves, but beyond {:g} mm they must be at rest", limits_.safety.clear_z_mm),
             "Wait for the end of the move first; [limits] clear_z_mm.");
    }
    if (limits_.has_force) check_fresh("TB-FORCE-STALE", name(axis), asked, "force sensor, tared,", force_time_);
  }
  if (axis != Axis::kZ) check_clear(axis, asked, read(Axis::kZ));
  log(name(axis), asked, true);
}

void Guard::check_home(Axis axis, const ReadAxis& read) {
  check_open(name(axis), "homing", axis == Axis::kZ);
  if (axis != Axis::kZ) check_clear(axis, "homing", read(Axis::kZ));
  log(name(axis), "homing", true);
}

void Guard::check_clear(Axis axis, const std::string& asked, const devices::AxisState& z) const {
  const double clear = limits_.safety.clear_z_mm;
  const auto refuse_for = [&](const std::string& why, const char* remedy) {
    refuse("TB-STAGE-ENVELOPE", name(axis), asked, why, remedy);
  };
  if (!z.homed) refuse_for("z was not homed, so it may be in contact", "Home z before x and y.");
  if (moving_[2] || z.activity != devices::Activity::kIdle) refuse_for("z moves", "Wait until z is at rest.");
  if (!(z.position.value() <= clear)) {
    refuse_for(fmt::format("z is at {:.2f} mm, beyond {:g} mm", z.position.value(), clear),
               "Retract z first; [limits] clear_z_mm.");
  }
  if (force_time_ < devices::Nanoseconds(0) || force_n_ < limits_.safety.contact_n) return;
  refuse_for(
      fmt::format("the last force reading was {:.2f} N, in contact from {:g} N", force_n_, limits_.safety.contact_n),
      "Retract z and read the force again; [limits] contact_n.");
}

}  // namespace tactbench::bench
