#include "analysis/compensate/compensator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

constexpr int kLongestMean = 16;  // samples: a held output that creeps is followed

}  // namespace

TaxelCompensator::TaxelCompensator(const ElamModel& model, const CompensatorOptions& options)
    : model_(&model), options_(options) {
  for (const double option : {options.noise_v, options.band_in_noises, options.hold_in_noises, options.flat_in_noises,
                              options.flat_psi, options.drift_share})
    if (!std::isfinite(option) || option < 0.0)
      throw std::invalid_argument("compensator: an option is negative or not a finite number");
  reset();
}

void TaxelCompensator::reset() {
  curve_.emplace(*model_, true, model_->x0(), model_->y0());
  set_extreme(model_->y0(), 1);
}

void TaxelCompensator::set_extreme(double volts, int samples) {
  extreme_v_ = volts;
  samples_ = samples;
  tentative_.reset();
}

// Where the rising curve is nearly flat, an output a few thousandths low (temperature, creep) puts the turn psi below
// xu, and the split with it: the whole falling curve is then misread by that much (0.2 % lower: 1.7 % of full pressure
// between up and down). Within drift_share of yu the split is taken as that of a turn at xu, fading out to twice that.
ElamCurve TaxelCompensator::curve_from_extreme() const {
  const double x = curve_->input(extreme_v_), xu = model_->xu();
  if (!curve_->ascending()) return {*model_, true, x, extreme_v_};
  const double drift = options_.drift_share * (model_->yu() - model_->y0());
  const double below = model_->yu() - extreme_v_;
  const double converged = drift > 0.0 ? std::clamp(2.0 - below / drift, 0.0, 1.0) : 0.0;
  return {*model_, false, x, extreme_v_, x + converged * (xu - x)};
}

bool TaxelCompensator::weak(const ElamCurve& curve, double volts) const {
  const double off = options_.flat_in_noises * options_.noise_v, here = curve.input(volts);
  return std::max(std::abs(curve.input(volts - off) - here), std::abs(curve.input(volts + off) - here)) >
         options_.flat_psi;
}

Compensated TaxelCompensator::step(double volts) {
  if (!std::isfinite(volts)) throw std::invalid_argument("compensator: the voltage is not a finite number");
  const double band = options_.band_in_noises * options_.noise_v;
  const double hold = std::min(options_.hold_in_noises * options_.noise_v, band);
  double ahead = curve_->ascending() ? volts - extreme_v_ : extreme_v_ - volts;
  if (ahead > hold) {
    set_extreme(volts, 1);
  } else if (ahead >= -hold) {
    const int samples = std::min(samples_ + 1, kLongestMean);
    set_extreme(extreme_v_ + (volts - extreme_v_) / samples, samples);
  } else if (ahead < -band) {
    curve_ = curve_from_extreme();
    set_extreme(volts, 1);
  }
  ahead = curve_->ascending() ? volts - extreme_v_ : extreme_v_ - volts;
  const bool back = ahead < -hold, held = !back && samples_ > 1;
  if ((back || held) && !tentative_) tentative_ = curve_from_extreme();
  const ElamCurve& curve = back ? *tentative_ : *curve_;

  Compensated result;
  result.pressure_psi = curve.input(volts);
  // A held output may have turned already: then the reverse curve says how much hides behind the noise.
  result.flat = weak(curve, volts) || (held && weak(*tentative_, volts));
  result.out_of_range = volts < model_->y0() - band || volts > model_->yu() + band;
  return result;
}

}  // namespace tactbench::analysis
