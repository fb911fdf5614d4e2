#include "analysis/compensate/dynamic_compensator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

DynamicTaxelCompensator::DynamicTaxelCompensator(const DynamicSetup& setup, std::size_t taxel)
    : setup_(&setup),
      taxel_(&setup.taxels.at(taxel)),
      options_(setup.options),
      divider_{0.0, taxel_->divider.per_amplitude},
      everett_{taxel_->everett.data(), setup.intervals},
      per_interval_((setup.x_high - setup.x_low) / static_cast<double>(setup.intervals)) {
  check_setup(setup);
  check_taxel(setup, *taxel_);
  options_.noise_v = taxel_->noise_v;
  options_.hold_in_noises = std::min(options_.hold_in_noises, options_.band_in_noises);
  top_ = divider_.output(everett_.top());
  reset();
}

void DynamicTaxelCompensator::reset() {
  memory_.start_low(0.0);
  unknown_ = false;
  started_ = decided_ = ascending_ = held_ = true;
  steps_ = kStepCeiling;
  mean_ = extreme_ = 0.0;
  weight_ = extreme_weight_ = 1.0;
  gain_ = 1.0;
  highest_ = 0.0;
  dynamics_ = {};
  work_unseen(setup_->dynamics, dynamics_, setup_->worked_s, setup_->x_high - setup_->x_low);
  last_x_ = last_slope_ = last_output_ = 0.0;
  last_factor_ = 1.0;  // of no account until a reading has a slope
}

void DynamicTaxelCompensator::rest(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0.0)
    throw std::invalid_argument("dynamic compensator: a time is negative or not a finite number");
  DynamicsState gone_on = dynamics_;
  advance(setup_->dynamics, gone_on, {setup_->dynamics, seconds}, 0.0);
  reset();
  dynamics_ = gone_on;
}

void DynamicTaxelCompensator::reset_unknown() {
  reset();
  other_.start_high(everett_, 0.0);
  unknown_ = true;
  started_ = decided_ = false;
}

void DynamicTaxelCompensator::work(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0.0)
    throw std::invalid_argument("dynamic compensator: a time is negative or not a finite number");
  work_unseen(setup_->dynamics, dynamics_, seconds, setup_->x_high - setup_->x_low);
}

// As TaxelCompensator's.
void DynamicTaxelCompensator::follow(double output) {
  const double off = output - mean_, noise2 = options_.noise_v * options_.noise_v;
  const double step = off * off * (noise2 > 0.0 ? 1.0 / noise2 : kNoNoise) * (1.0 - 0.5 * weight_);
  const bool moving = steps_ > options_.moving;
  steps_ += (std::min(step, kStepCeiling) - steps_) * (1.0 / kStepWindow);
  if (moving || off * off > options_.jump_in_noises * options_.jump_in_noises * noise2 * (1.0 + weight_)) {
    weight_ = 1.0;
    mean_ = output;
  } else {
    weight_ = std::max(weight_ / (1.0 + weight_), 1.0 / options_.longest_mean);
    mean_ += weight_ * off;
  }
}

double DynamicTaxelCompensator::extreme() const {
  if (!decided_) return extreme_;
  const double lead = options_.lead_in_noises * options_.noise_v * std::sqrt(extreme_weight_) * (1.0 - extreme_weight_);
  return ascending_ ? extreme_ - lead : extreme_ + lead;
}

double DynamicTaxelCompensator::behind_extreme() const { return ascending_ ? extreme() - mean_ : mean_ - extreme(); }

double DynamicTaxelCompensator::squared_noise(double noises) const {
  return noises * noises * options_.noise_v * options_.noise_v * std::max(weight_, extreme_weight_);
}

void DynamicTaxelCompensator::take_extreme() {
  extreme_ = mean_;
  extreme_weight_ = weight_;
}

void DynamicTaxelCompensator::turn(Staircase<double>& memory, double output) { memory.turn(everett_, linear(output)); }

// At a turn from rising to falling, before it is remembered.
void DynamicTaxelCompensator::observe_top() {
  const double measured = extreme() / gain_, share = setup_->observer.share;
  if (share <= 0.0 || measured < (1.0 - share) * top_) return;
  highest_ = std::max(measured, highest_ - setup_->observer.forget * (highest_ - measured));
  const double gain = std::clamp(top_ / highest_, 1.0 / (1.0 + 5.0 * share), 1.0 / (1.0 - share));
  const double change = gain / gain_;
  gain_ = gain;
  mean_ *= change;
  extreme_ *= change;
  last_output_ *= change;
}

void DynamicTaxelCompensator::decide_when_beyond() {
  const double off = mean_ - extreme_;
  if (off * off > squared_noise(options_.band_in_noises)) {
    turn(off > 0.0 ? other_ : memory_, extreme_);
    decided_ = true;
    ascending_ = off > 0.0;
    held_ = false;
    take_extreme();
  } else if (weight_ < extreme_weight_) {
    take_extreme();
  }
}

void DynamicTaxelCompensator::turn_when_beyond() {
  const double ahead = ascending_ ? mean_ - extreme_ : extreme_ - mean_;
  const double behind = behind_extreme(), behind2 = behind > 0.0 ? behind * behind : 0.0;
  const double rest = options_.rest_in_noises * options_.noise_v;
  held_ = ahead <= 0.0 || ahead * ahead <= squared_noise(options_.hold_in_noises);
  const bool turned = behind2 > squared_noise(options_.band_in_noises);
  const bool rested = weight_ <= 1.0 / options_.longest_mean && extreme_weight_ > weight_ && behind2 <= rest * rest;
  if (turned) {
    if (ascending_) observe_top();
    turn(memory_, extreme());
    if (unknown_) turn(other_, extreme());
    ascending_ = !ascending_;
    held_ = false;
  }
  if (turned || ahead >= 0.0 || rested) take_extreme();
}

DynamicTaxelCompensator::Reading DynamicTaxelCompensator::reading(const Staircase<double>& memory,
                                                                  double output) const {
  const double u = linear(output), share = 1.0 - std::min(output * divider_.per_amplitude, Divider::kMost);
  const BranchPiece<double> piece = memory.piece(everett_, u);
  return {piece.along(u), piece.slope / (share * share)};
}

double DynamicTaxelCompensator::sensitivity(const Staircase<double>& memory) const {
  const double off = options_.flat_in_noises * options_.noise_v, here = reading(memory, mean_).x;
  if (off <= 0.0) return 0.0;
  return per_interval_ * std::max(here - reading(memory, mean_ - off).x, reading(memory, mean_ + off).x - here) / off;
}

Compensated DynamicTaxelCompensator::read(const Staircase<double>& memory, Reading& here) const {
  const double behind = behind_extreme();
  const bool back = decided_ && behind > 0.0 && behind * behind > squared_noise(options_.hold_in_noises);
  Compensated result;
  here = reading(memory, mean_);
  double slope = sensitivity(memory), doubt = 0.0;
  if (back || (decided_ && held_)) {
    Staircase<double> tentative = memory;
    tentative.turn(everett_, linear(extreme()));
    slope = std::max(slope, sensitivity(tentative));
    if (back) {
      const Reading there = reading(tentative, mean_);
      doubt = per_interval_ * std::abs(there.x - here.x) / std::sqrt(12.0);
      here = there;
    }
  }
  const double noise = options_.noise_v * std::sqrt(weight_);
  result.uncertainty_psi = std::hypot(noise * slope, doubt);
  result.flat = options_.flat_in_noises * noise * slope > options_.flat_psi;
  return result;
}

double DynamicTaxelCompensator::residual() const {
  const std::size_t n = setup_->intervals;
  if (setup_->residual_psi.empty()) return 0.0;
  const std::size_t at = interval_of(last_x_, n);
  const double changed =
      setup_->observer.doubt * std::abs(1.0 - gain_) * (static_cast<double>(at) + 0.5) * per_interval_;
  return std::hypot(taxel_->residual_scale * setup_->residual_psi.at(ascending_ ? at : n + at), changed);
}

void DynamicTaxelCompensator::settle_history(Compensated& result) {
  Reading here{last_x_, last_slope_}, there;
  const Compensated low = read(other_, there);
  const double apart = per_interval_ * std::abs(here.x - there.x);
  if (apart <= options_.known_psi) {
    unknown_ = false;
    if (!decided_) take_extreme();
    decided_ = true;
    return;
  }
  last_x_ = 0.5 * (here.x + there.x);
  result.uncertainty_psi = std::hypot(std::max(result.uncertainty_psi, low.uncertainty_psi), 0.5 * apart);
  result.flat = result.flat || low.flat;
  result.unknown = true;
}

Compensated DynamicTaxelCompensator::step(double volts, double seconds) {
  if (!std::isfinite(volts) || !std::isfinite(seconds) || seconds < 0.0)
    throw std::invalid_argument("dynamic compensator: a voltage or time is not a finite number");
  const Dynamics& d = setup_->dynamics;
  const DynamicsStep passed(d, seconds);
  const double above = ((taxel_->falling ? -volts : volts) - taxel_->divider.zero) * gain_;
  // The creep's target needs the pressure: guessed along the slope of the last reading.
  const double moved = last_slope_ * (above / last_factor_ - last_output_);
  const double most = static_cast<double>(setup_->intervals);
  const double guess = per_interval_ * std::clamp(last_x_ + moved, 0.0, most);
  last_factor_ = creep_factor(d, dynamics_, passed, guess, taxel_->creep_scale);
  const double output = above / last_factor_;
  if (started_) {
    follow(output);
  } else {
    mean_ = extreme_ = output;
    started_ = true;
  }
  decided_ ? turn_when_beyond() : decide_when_beyond();
  if (decided_ && (ascending_ ? mean_ >= extreme_ : mean_ <= extreme_)) {
    memory_.go(linear(mean_));
    if (unknown_) other_.go(linear(mean_));
  }
  Reading here;
  Compensated result = read(memory_, here);
  last_x_ = here.x;
  last_slope_ = std::min(here.slope, kSteepestGuess * most / top_);
  last_output_ = mean_;
  if (unknown_) settle_history(result);
  const double arrived_psi = per_interval_ * last_x_;
  const double pressure =
      std::clamp(before_lag(taxel_->lag_share, dynamics_, passed, arrived_psi), 0.0, per_interval_ * most);
  advance(d, dynamics_, passed, pressure);
  result.pressure_psi = setup_->x_low + pressure;
  result.uncertainty_psi = std::hypot(result.uncertainty_psi, residual());
  const double band = options_.band_in_noises * options_.noise_v;
  result.out_of_range = output < -band || output > top_ + band;
  return result;
}

}  // namespace tactbench::analysis
