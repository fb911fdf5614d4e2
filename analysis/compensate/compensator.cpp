#include "analysis/compensate/compensator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

TaxelCompensator::TaxelCompensator(const ElamModel& model, const CompensatorOptions& options)
    : model_(&model), options_(options), curve_(model, true, model.x0(), model.y0()) {
  check_options(options);
  options_.hold_in_noises = std::min(options.hold_in_noises, options.band_in_noises);
  reset();
}

void TaxelCompensator::reset() {
  curve_ = ElamCurve(*model_, true, model_->x0(), model_->y0());
  other_.reset();
  started_ = decided_ = ascending_ = true;
  steps_ = kStepCeiling;
  mean_v_ = extreme_v_ = model_->y0();
  gain_ = extreme_gain_ = 1.0;
}

void TaxelCompensator::reset_unknown() {
  reset();
  other_.emplace(*model_, false, model_->xu(), model_->yu());
  started_ = decided_ = false;
}

void TaxelCompensator::follow(double volts) {
  const double off = volts - mean_v_, noise2 = options_.noise_v * options_.noise_v;
  // A step's variance is noise2 (1 + gain); 1 - gain / 2 is close enough to the inverse and needs no division.
  const double step = off * off * (noise2 > 0.0 ? 1.0 / noise2 : kNoNoise) * (1.0 - 0.5 * gain_);
  const bool moving = steps_ > options_.moving;
  steps_ += (std::min(step, kStepCeiling) - steps_) * (1.0 / kStepWindow);
  if (moving || off * off > options_.jump_in_noises * options_.jump_in_noises * noise2 * (1.0 + gain_)) {
    gain_ = 1.0;
    mean_v_ = volts;
  } else {
    gain_ = std::max(gain_ / (1.0 + gain_), 1.0 / options_.longest_mean);
    mean_v_ += gain_ * off;
  }
}

// The highest of many means lies too high: reduced by the lead, which is 0 for a single sample.
double TaxelCompensator::extreme() const {
  if (!decided_) return extreme_v_;
  const double lead = options_.lead_in_noises * options_.noise_v * std::sqrt(extreme_gain_) * (1.0 - extreme_gain_);
  return ascending_ ? extreme_v_ - lead : extreme_v_ + lead;
}

double TaxelCompensator::behind_extreme() const { return ascending_ ? extreme() - mean_v_ : mean_v_ - extreme(); }

double TaxelCompensator::squared_noise(double noises) const {
  return noises * noises * options_.noise_v * options_.noise_v * std::max(gain_, extreme_gain_);
}

// Where the rising curve is nearly flat, an output a few thousandths low (temperature, creep) puts the turn psi below
// xu, and the split with it: the whole falling curve is then misread by that much (0.2 % lower: 1.7 % of full pressure
// between up and down). Within drift_share of yu the split is taken as that of a turn at xu, fading out to twice that.
ElamCurve TaxelCompensator::reversed(const ElamCurve& curve) const {
  const double turn = extreme(), x = curve.input(turn), xu = model_->xu();
  if (!curve.ascending()) return {*model_, true, x, turn};
  const double drift = options_.drift_share * (model_->yu() - model_->y0());
  const double converged = drift > 0.0 ? std::clamp(2.0 - (model_->yu() - turn) / drift, 0.0, 1.0) : 0.0;
  return {*model_, false, x, turn, x + converged * (xu - x)};
}

void TaxelCompensator::take_extreme() {
  extreme_v_ = mean_v_;
  extreme_gain_ = gain_;
}

// A start whose direction is not known yet: the first mean is kept until the output has left it.
void TaxelCompensator::decide_when_beyond() {
  const double off = mean_v_ - extreme_v_;
  if (off * off > squared_noise(options_.band_in_noises)) {
    ElamCurve& turned = off > 0.0 ? *other_ : curve_;  // one of the two histories has just turned
    turned = reversed(turned);
    decided_ = true;
    ascending_ = off > 0.0;
    held_ = false;
    take_extreme();
  } else if (gain_ < extreme_gain_) {
    take_extreme();
  }
}

void TaxelCompensator::turn_when_beyond() {
  const double ahead = ascending_ ? mean_v_ - extreme_v_ : extreme_v_ - mean_v_;
  const double behind = behind_extreme(), behind2 = behind > 0.0 ? behind * behind : 0.0;
  const double rest = options_.rest_in_noises * options_.noise_v;
  held_ = ahead <= 0.0 || ahead * ahead <= squared_noise(options_.hold_in_noises);
  const bool turned = behind2 > squared_noise(options_.band_in_noises);
  // It came to rest so near that the extreme was noise.
  const bool rested = gain_ <= 1.0 / options_.longest_mean && extreme_gain_ > gain_ && behind2 <= rest * rest;
  if (turned) {
    curve_ = reversed(curve_);
    if (other_) other_ = reversed(*other_);
    ascending_ = !ascending_;
    held_ = false;
  }
  if (turned || ahead >= 0.0 || rested) take_extreme();
}

double TaxelCompensator::sensitivity(const ElamCurve& curve) const {
  const double off = options_.flat_in_noises * options_.noise_v, here = curve.input(mean_v_);
  if (off <= 0.0) return 0.0;
  return std::max(here - curve.input(mean_v_ - off), curve.input(mean_v_ + off) - here) / off;
}

Compensated TaxelCompensator::read(const ElamCurve& curve) const {
  const double behind = behind_extreme();
  const bool back = decided_ && behind > 0.0 && behind * behind > squared_noise(options_.hold_in_noises);
  Compensated result;
  result.pressure_psi = curve.input(mean_v_);
  double slope = sensitivity(curve), doubt = 0.0;
  if (back || (decided_ && held_)) {
    // It may have turned already: then the reverse curve shows how much pressure hides behind the noise.
    const ElamCurve tentative = reversed(curve);
    slope = std::max(slope, sensitivity(tentative));
    if (back) {
      const double there = tentative.input(mean_v_);
      doubt = std::abs(there - result.pressure_psi) / std::sqrt(12.0);  // turned or not: anywhere between
      result.pressure_psi = there;
    }
  }
  const double noise = options_.noise_v * std::sqrt(gain_);
  result.uncertainty_psi = std::hypot(noise * slope, doubt);
  result.flat = options_.flat_in_noises * noise * slope > options_.flat_psi;
  return result;
}

void TaxelCompensator::settle_history(Compensated& result) {
  const Compensated low = read(*other_);
  const double apart = std::abs(result.pressure_psi - low.pressure_psi);
  if (apart <= options_.known_psi) {
    other_.reset();
    if (!decided_) take_extreme();
    decided_ = true;
    return;
  }
  result.pressure_psi = 0.5 * (result.pressure_psi + low.pressure_psi);
  // Half the distance, since ELAM's inner curves may leave the space between the two.
  result.uncertainty_psi = std::hypot(std::max(result.uncertainty_psi, low.uncertainty_psi), 0.5 * apart);
  result.flat = result.flat || low.flat;
  result.unknown = true;
}

Compensated TaxelCompensator::step(double volts) {
  if (!std::isfinite(volts)) throw std::invalid_argument("compensator: the voltage is not a finite number");
  if (started_) {
    follow(volts);
  } else {
    mean_v_ = extreme_v_ = volts;
    started_ = true;
  }
  decided_ ? turn_when_beyond() : decide_when_beyond();
  Compensated result = read(curve_);
  if (other_) settle_history(result);
  const double band = options_.band_in_noises * options_.noise_v;
  result.out_of_range = volts < model_->y0() - band || volts > model_->yu() + band;
  return result;
}

}  // namespace tactbench::analysis
