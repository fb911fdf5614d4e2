#include "analysis/compensate/compensator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "analysis/compensate/curves.h"
#include "analysis/compensate/turning.h"
#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {

double FrameCompensator::checked(std::size_t outputs, double seconds, const Output& output) {
  const std::size_t count = taxels();
  if (outputs != count || output.pressure_psi.size() != count || output.uncertainty_psi.size() != count ||
      output.status.size() != count)
    throw std::invalid_argument(
        "frames: the number of samples, or of values in an output, differs from the number of taxels");
  if (!begun_) return 0.0;
  if (std::isnan(seconds) && !setup_.in_time) return 0.0;
  if (std::isnan(seconds))
    throw std::invalid_argument(
        "frames: the model compensates lag and creep, but the time since the previous frame is not given");
  if (seconds < 0.0 || std::isinf(seconds))
    throw std::invalid_argument("frames: the time since the previous frame is negative or infinite");
  return seconds;
}

void FrameCompensator::put(std::size_t taxel, const Compensated& now, int bits, const Output& output) const {
  if (now.out_of_range)
    bits |= kTaxelOutOfRange;
  else if (!now.held && !outside_)
    bits |= kTaxelValid;
  if (now.flat) bits |= kTaxelFlat;
  if (now.unknown) bits |= kTaxelUnknown;
  if (outside_ && bits != kTaxelDead) bits |= kTaxelOutside;
  output.pressure_psi[taxel] = static_cast<float>(now.pressure_psi);
  output.uncertainty_psi[taxel] = static_cast<float>(std::min(now.uncertainty_psi, setup_.x_high - setup_.x_low));
  output.status[taxel] = static_cast<std::uint16_t>(bits);
}

void FrameCompensator::frame(std::span<const float> outputs, double seconds, const Output& output) {
  const double passed = checked(outputs.size(), seconds, output);
  const Compensated dead{setup_.x_low, setup_.x_high - setup_.x_low, false, false, false, true};
  for (std::size_t t = 0; t < outputs.size(); ++t) {
    if (setup_.taxels[t] == nullptr)
      put(t, dead, kTaxelDead, output);
    else
      put(t, setup_.taxels[t]->step(static_cast<double>(outputs[t]), passed),
          std::isfinite(outputs[t]) ? 0 : kTaxelLost, output);
  }
  begun_ = true;
  gap_ = 0;
}

void FrameCompensator::lost_frame(double seconds, const Output& output) {
  const double passed = checked(taxels(), seconds, output);
  const bool unknown = ++gap_ > setup_.max_gap;
  const Compensated dead{setup_.x_low, setup_.x_high - setup_.x_low, false, false, false, true};
  for (std::size_t t = 0; t < taxels(); ++t) {
    Compensator* const own = setup_.taxels[t].get();
    if (own == nullptr) {
      put(t, dead, kTaxelDead, output);
      continue;
    }
    if (unknown) own->start(Start::kUnknown);
    put(t, own->lost(passed), kTaxelLost, output);
  }
}

void FrameCompensator::start(Start how) {
  begun_ = false;
  gap_ = 0;
  for (const auto& own : setup_.taxels)
    if (own != nullptr) own->start(how);
}

void FrameCompensator::work(double seconds) {
  for (const auto& own : setup_.taxels)
    if (own != nullptr) own->work(seconds);
}

std::size_t FrameCompensator::tare(std::span<const float> outputs) {
  if (outputs.size() != taxels())
    throw std::invalid_argument("frames: the number of samples differs from the number of taxels");
  std::size_t refused = 0;
  begun_ = false;
  gap_ = 0;
  for (std::size_t t = 0; t < outputs.size(); ++t)
    if (setup_.taxels[t] != nullptr && !setup_.taxels[t]->tare(static_cast<double>(outputs[t]))) ++refused;
  return refused;
}

namespace {

// Bounds on a document's numbers, so that no square or quotient overflows.
constexpr double kMost = 1e9, kLeastSpan = 1e-9;
constexpr double kLeastOutput = 1e-3;  // the full output in noises

void demand(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument(what);
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

void check(const CompensatorSetup& setup) {
  demand(within(setup.noise, 0.0, kMost), "its noise is not within 0 and 1e9");
  demand(within(std::abs(setup.gain), 1e-9, kMost) && within(std::abs(setup.zero), 0.0, kMost),
         "its gain or zero is not within 1e-9 and 1e9");
  for (const double left : setup.residual) demand(within(left, 0.0, kMost), "its residual is not within 0 and 1e9");
  demand(setup.residual.size() % 2 == 0, "its residual does not consist of pairs, rising and falling");
  demand(within(setup.worked_s, 0.0, kMost), "the time worked is not within 0 and 1e9 s");
  demand(within(std::abs(setup.highest), 0.0, kMost), "its highest output is not within 1e9");
  const CompensatorOptions& o = setup.options;
  for (const double option : {o.moving, o.jump_in_noises, o.lead_in_noises, o.band_in_noises, o.rest_in_noises,
                              o.hold_in_noises, o.flat_in_noises, o.flat_share, o.known_share, o.tare_share,
                              o.possible_share, o.top_forget, o.top_doubt, o.creep_doubt, o.swift_doubt})
    demand(within(option, 0.0, kMost), "an option is not within 0 and 1e9");
  demand(o.longest_mean >= 1 && o.longest_spike >= 0 && o.top_share >= 0.0 && o.top_share < 1.0,
         "longest_mean is below 1, longest_spike negative or top_share not within 0 and 1");
  if (!setup.time) return;
  const Dynamics& d = setup.time->dynamics;
  double sum = 0.0;
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    demand(std::isfinite(d.creep_s[j]) && d.creep_s[j] > 0.0, "a creep time is not positive");
    demand(d.creep_share[j] >= 0.0, "a creep share is negative or not finite");
    sum += d.creep_share[j];
  }
  demand(within(setup.creep_scale, 0.0, kMaxCreepScale), "its creep is not within 0 and 10");
  demand(sum <= kMaxCreep && setup.creep_scale * sum <= kMaxCreep, "its creep exceeds 0.9 of its output");
  demand(within(d.creep_half, kLeastSpan, kMost), "creep_half is not within 1e-9 and 1e9");
  demand(std::isfinite(d.lag_s) && d.lag_s > 0.0, "the lag's time is not positive");
  demand(within(setup.lag_share, 0.0, 0.9), "its lag is not within 0 and 0.9");
}

template <class Curve>
std::unique_ptr<Compensator> of_curve(Curve curve, const CompensatorSetup& setup) {
  demand(within(curve.x_high() - curve.x_low(), kLeastSpan, kMost) && std::abs(curve.x_low()) <= kMost,
         "the span of its inputs is not within 1e-9 and 1e9, or they begin beyond 1e9");
  const double full = curve.top() * std::abs(setup.gain);
  demand(std::isfinite(full) && full > 0.0, "its output does not rise");
  demand(full >= kLeastOutput * setup.noise, "its full output is below a thousandth of its noise");
  return std::make_unique<TurningCompensator<Curve>>(std::move(curve), setup);
}

}  // namespace

std::unique_ptr<Compensator> make_compensator(const HysteresisModel& model, const CompensatorSetup& setup) {
  check(setup);
  CompensatorSetup own = setup;  // its zero becomes the output at the lowest input
  const auto count_from = [&](double low) { own.zero += own.gain * low; };
  if (const auto* const elam = dynamic_cast<const ElamHysteresis*>(&model); elam != nullptr && elam->is_paper()) {
    count_from(elam->elam().y0());
    return of_curve(ElamStack(elam->elam()), own);
  }
  const auto* const outer = dynamic_cast<const LinearisedModel*>(&model);
  const Divider divider = outer == nullptr ? Divider() : outer->divider();
  const auto* const film = dynamic_cast<const PreisachModel*>(outer == nullptr ? &model : &outer->inner());
  // The curve measures u from the unloaded output, as a divider does.
  if (film != nullptr && (divider.per_amplitude == 0.0 ||
                          std::abs(film->y_low()) <= 1e-9 * film->everett(film->x_high(), film->x_low()))) {
    count_from(divider.zero + (divider.per_amplitude > 0.0 ? 0.0 : film->y_low()));
    return of_curve(PreisachCurve(PreisachCurve::film_of(*film, divider)), own);
  }
  StateCurve curve(model, setup.highest);
  count_from(curve.low());
  return of_curve(std::move(curve), own);
}

}  // namespace tactbench::analysis
