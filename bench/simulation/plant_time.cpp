// How the plant goes through time: a fixed grid, cut where a command or its time limit changes the drive.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/simulation/plant.h"

namespace tactbench::bench {
namespace {

using devices::Nanoseconds;

constexpr Nanoseconds kCell = std::chrono::milliseconds(10);
// The specimen moves when the pressure on some taxel has changed by this much, at each turning point, and in calm
// pressure at times that grow with the calm, as creep's rate falls with it.
constexpr double kMovePsi = 0.25;
constexpr double kTurnPsi = 0.001;
constexpr double kShortestCalmSeconds = 0.1;
constexpr double kLongestCalmSeconds = 60.0;
constexpr double kCalmGrowth = 0.5;

double seconds_of(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

// True at a turn; `direction` follows `change`.
bool turns(int& direction, double change) {
  const int now = change > 0.0 ? 1 : (change < 0.0 ? -1 : direction);
  const bool turned = now != direction;
  direction = now;
  return turned;
}

}  // namespace

void Plant::set_stage(const devices::StageView* stage) {
  const std::lock_guard lock(mutex_);
  advance_to(clock_.now());
  stage_ = stage;
  contact_state_ = {};
}

void Plant::forget_stage() {
  const std::lock_guard lock(mutex_);
  stage_ = nullptr;
}

void Plant::advance_to(Nanoseconds time) {
  const Nanoseconds last = time / kCell * kCell;
  if (last <= time_) return;
  stage_rests_ = stage_ == nullptr || (contact_.quiet(contact_state_) && stage_->at_rest_since(time_));
  for (Nanoseconds next = (time_ / kCell + 1) * kCell; next <= last; next += kCell) step_to(next);
  stage_rests_ = false;
}

void Plant::step_to(Nanoseconds time) {
  while (time_ < time) {
    if (held_ && hold_until_ <= time_) {
      held_ = false;
      command_ = fallback_;
      chamber_.command(fallback_);
    }
    if (faults_.any()) suffer();
    const Nanoseconds end = held_ ? std::min(time, hold_until_) : time;
    const double seconds = seconds_of(end - time_);
    chamber_.advance(seconds);
    instruments_.follow(chamber_.pressure().value());
    time_ = end;
    if (!stage_rests_ && stage_ != nullptr) follow_stage(seconds);
    follow(seconds);
    faults_.load(chamber_.pressure().value(), contact_state_.force_n, time_);
  }
}

void Plant::suffer() {
  const auto value = [&](FaultKind kind) { return faults_.active(kind, time_); };
  ChamberTrouble trouble;
  trouble.valve_shut = value(FaultKind::kValveStuck) || value(FaultKind::kRegulatorUnpowered);
  trouble.leak_psi_per_s = value(FaultKind::kLeak).value_or(0.0);
  trouble.no_supply_fall_psi_per_s = value(FaultKind::kSupplyLost).value_or(0.0);
  chamber_.set_trouble(trouble);
}

void Plant::follow_stage(double seconds) {
  const auto places = stage_->places(time_);
  contact_.advance(contact_state_, places[2].value(), seconds);
  if (contact_state_.force_n == 0.0) return;
  const auto& shape = contact_.psi_per_newton(places[0].value(), places[1].value());
  if (shape == psi_per_newton_) return;
  psi_per_newton_ = shape;
  peak_psi_per_newton_ = *std::max_element(shape.begin(), shape.end());
  shifted_ = true;
}

ContactState Plant::contact_now() {
  const Nanoseconds now = clock_.now();
  advance_to(now);
  ContactState state = contact_state_;
  if (stage_ != nullptr && time_ < now) {
    contact_.advance(state, stage_->places(now)[2].value(), seconds_of(now - time_));
  }
  return state;
}

std::span<const double> Plant::contact_psi(double force_n) {
  if (!(force_n > 0.0) || psi_per_newton_.empty()) return {};
  contact_psi_.resize(psi_per_newton_.size());
  std::transform(psi_per_newton_.begin(), psi_per_newton_.end(), contact_psi_.begin(),
                 [&](double psi) { return psi * force_n; });
  return contact_psi_;
}

void Plant::follow(double seconds) {
  const Load now = load();
  const bool turned = turns(direction_, now.chamber_psi - previous_.chamber_psi);
  const bool contact_turned = turns(contact_direction_, now.force_n - previous_.force_n);
  // The turning point itself: plays remember it.
  if (pending_s_ > 0.0 && ((turned && std::abs(previous_.chamber_psi - moved_.chamber_psi) > kTurnPsi) ||
                           (contact_turned && peak_psi(std::abs(previous_.force_n - moved_.force_n)) > kTurnPsi))) {
    move_specimen(previous_, pending_s_);
    pending_s_ = 0.0;
  }
  previous_ = now;
  pending_s_ += seconds;
  calm_s_ += seconds;
  volts_fresh_ = false;
  if (std::abs(now.chamber_psi - moved_.chamber_psi) >= kMovePsi ||
      peak_psi(std::abs(now.force_n - moved_.force_n)) >= kMovePsi || shifted_) {
    move_specimen(now, pending_s_);
    pending_s_ = 0.0;
    calm_s_ = 0.0;
    shifted_ = false;
  } else if (pending_s_ >= std::clamp(kCalmGrowth * calm_s_, kShortestCalmSeconds, kLongestCalmSeconds)) {
    move_specimen(now, pending_s_);
    pending_s_ = 0.0;
  }
}

void Plant::move_specimen(const Load& load, double seconds) {
  specimen_.advance(load.chamber_psi, seconds, contact_psi(load.force_n));
  moved_ = load;
}

}  // namespace tactbench::bench
