#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/compensate/frame_state.h"

namespace tactbench::analysis {

namespace {

constexpr double kNoSample = 1e15;  // a mean that any sample is far from

template <class Real, class Sample>
void run_pass(FrameLanes<Real>& lanes, const Sample* samples, Dispatch dispatch) {
  using Passes = FramePasses<Real, Sample>;
  const FramePass<Real, Sample> pass = dispatch == Dispatch::kAvx2 ? &Passes::avx2 : &Passes::base;
  pass(lanes, samples);
}

}  // namespace

template <class Real>
void FrameCompensator<Real>::State::take_extreme(std::size_t taxel) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  b.extreme[i] = b.mean[i];
  b.extreme_weight[i] = b.weight[i];
  b.turn[i] = b.mean[i] -
              b.sign[i] * static_cast<Real>(lanes.options.lead_in_noises) * b.root_weight[i] * (Real(1) - b.weight[i]);
}

// The next sample looks for its piece.
template <class Real>
void FrameCompensator<Real>::State::set_curve(std::size_t taxel, const ComposedCurve& curve) {
  constexpr Real kUnknown = std::numeric_limits<Real>::quiet_NaN();
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  lanes.curves[taxel] = curve;
  std::fill_n(lanes.sensitivities_of(taxel), lanes.knots + 3, KnotSensitivity<Real>{kUnknown, kUnknown});
  b.from[i] = static_cast<Real>(kFar);
  b.to[i] = static_cast<Real>(-kFar);
  b.back_turn[i] = kUnknown;
  lanes.former[taxel] = {b.from[i], b.to[i], Real(0), Real(0), kUnknown, kUnknown, 0};
}

template <class Real>
void FrameCompensator<Real>::State::start_lane(std::size_t taxel, bool unknown) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  const TaxelPattern& pattern = lanes.patterns[taxel];
  const double x0 = pattern.x.front(), xu = pattern.x.back();
  histories[taxel] = {};
  histories[taxel].unknown = unknown;
  b.steps[i] = static_cast<Real>(kStepCeiling);
  b.weight[i] = b.root_weight[i] = b.extreme_weight[i] = Real(1);
  b.turn[i] = b.extreme[i] = Real(0);
  b.mean[i] = unknown ? static_cast<Real>(kNoSample) : Real(0);
  b.sign[i] = unknown ? Real(0) : Real(1);
  b.pressure[i] = static_cast<Real>(x0);
  b.uncertainty[i] = static_cast<Real>(unknown ? span_psi : 0.0);
  set_curve(taxel, curve_from(pattern, true, x0, 0.0, x0));
  if (!unknown) return;
  histories[taxel].other = curve_from(pattern, false, xu, pattern.span, xu);
  // One piece that holds everything and tells nothing: an event in each frame.
  b.from[i] = static_cast<Real>(-kFar);
  b.to[i] = static_cast<Real>(kFar);
  b.sensitivity[i] = std::numeric_limits<Real>::quiet_NaN();
}

template <class Real>
void FrameCompensator<Real>::State::write(const Output& output, bool all_lost) const {
  const std::size_t count = lanes.taxels;
  for (std::size_t first = 0; first < count; first += kLanes) {
    const LaneBlock<Real>& b = lanes.block(first);
    const auto copy = [&](std::size_t here) {
      std::copy_n(b.pressure, here, output.pressure_psi.data() + first);
      std::copy_n(b.uncertainty, here, output.uncertainty_psi.data() + first);
      for (std::size_t i = 0; i < here; ++i) output.status[first + i] = static_cast<std::uint16_t>(b.bits[i]);
    };
    if (count - first >= kLanes)
      copy(kLanes);  // a length that the compiler knows
    else
      copy(count - first);
  }
  if (outside)
    for (std::uint16_t& bits : output.status) bits = static_cast<std::uint16_t>((bits & ~kTaxelValid) | kTaxelOutside);
  const std::uint16_t lost_bits = static_cast<std::uint16_t>(kTaxelLost | (outside ? kTaxelOutside : 0));
  const auto mark_lost = [&](std::size_t taxel) {
    output.status[taxel] = static_cast<std::uint16_t>(lost_bits | (histories[taxel].unknown ? kTaxelUnknown : 0));
  };
  if (all_lost)
    for (std::size_t taxel = 0; taxel < count; ++taxel) mark_lost(taxel);
  for (const SavedLane& lane : saved) mark_lost(lane.taxel);
  for (const std::size_t taxel : dead) {
    output.pressure_psi[taxel] = static_cast<Real>(lowest_psi);
    output.uncertainty_psi[taxel] = static_cast<Real>(span_psi);
    output.status[taxel] = kTaxelDead;
  }
}

template <class Real>
void FrameCompensator<Real>::State::save_lane(std::size_t taxel) {
  const LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  saved.push_back({taxel, b.steps[i], b.mean[i], b.weight[i], b.root_weight[i], b.extreme[i], b.extreme_weight[i],
                   b.turn[i], b.pressure[i], b.uncertainty[i]});
  lost[taxel] = true;
}

template <class Real>
void FrameCompensator<Real>::State::restore_lanes() {
  for (const SavedLane& lane : saved) {
    LaneBlock<Real>& b = lanes.block(lane.taxel);
    const std::size_t i = lane.taxel % kLanes;
    b.steps[i] = lane.steps;
    b.mean[i] = lane.mean;
    b.weight[i] = lane.weight;
    b.root_weight[i] = lane.root_weight;
    b.extreme[i] = lane.extreme;
    b.extreme_weight[i] = lane.extreme_weight;
    b.turn[i] = lane.turn;
    b.pressure[i] = lane.pressure;
    b.uncertainty[i] = lane.uncertainty;
  }
}

template <class Real>
void FrameCompensator<Real>::State::check(std::size_t samples, const Output& output) const {
  const std::size_t count = lanes.taxels;
  if (samples != count || output.pressure_psi.size() != count || output.uncertainty_psi.size() != count ||
      output.status.size() != count)
    throw std::invalid_argument("frame compensator: the samples or an output are not one a taxel");
}

template <class Real>
void FrameCompensator<Real>::frame(std::span<const std::uint16_t> counts, const Output& output) {
  State& s = *state_;
  s.check(counts.size(), output);
  const std::uint16_t* samples = counts.data();
  if (counts.size() % kLanes != 0) {
    std::ranges::copy(counts, s.counts.begin());
    samples = s.counts.data();
  }
  run_pass(s.lanes, samples, s.dispatch);
  s.attend();
  s.write(output, false);
  s.gap = 0;
}

template <class Real>
void FrameCompensator<Real>::frame(std::span<const Real> volts, const Output& output) {
  State& s = *state_;
  s.check(volts.size(), output);
  for (std::size_t i = 0; i < volts.size(); ++i) {
    const bool number = std::isfinite(volts[i]);
    s.volts[i] = number ? volts[i] : Real(0);
    if (!number) s.save_lane(i);
  }
  run_pass(s.lanes, static_cast<const Real*>(s.volts.data()), s.dispatch);
  s.attend();
  s.restore_lanes();
  s.write(output, false);
  for (const auto& lane : s.saved) s.lost[lane.taxel] = false;
  s.saved.clear();
  s.gap = 0;
}

template <class Real>
void FrameCompensator<Real>::lost_frame(const Output& output) {
  State& s = *state_;
  s.check(s.lanes.taxels, output);
  if (++s.gap > s.longest_gap) reset_unknown();
  // What comes next is taken as it comes: the output may have gone anywhere meanwhile.
  for (LaneBlock<Real>& b : s.lanes.blocks) std::fill_n(b.steps, kLanes, static_cast<Real>(kStepCeiling));
  s.write(output, true);
}

template <class Real>
std::size_t FrameCompensator<Real>::tare(std::span<const std::uint16_t> counts) {
  State& s = *state_;
  if (counts.size() != s.lanes.taxels)
    throw std::invalid_argument("frame compensator: the samples are not one a taxel");
  std::size_t refused = 0;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (s.lanes.patterns[t].x.empty()) continue;
    LaneBlock<Real>& b = s.lanes.block(t);
    const std::size_t i = t % kLanes;
    const Real moved = b.gain[i] * (static_cast<Real>(counts[t]) - b.zero[i]);
    const bool small = std::abs(static_cast<double>(moved)) <= s.tare_share * s.lanes.patterns[t].span;
    if (small) b.zero[i] = static_cast<Real>(counts[t]);
    refused += small ? 0 : 1;
    s.start_lane(t, !small);
  }
  return refused;
}

template <class Real>
void FrameCompensator<Real>::reset() {
  for (std::size_t t = 0; t < state_->lanes.taxels; ++t)
    if (!state_->lanes.patterns[t].x.empty()) state_->start_lane(t, false);
}

template <class Real>
void FrameCompensator<Real>::reset_unknown() {
  for (std::size_t t = 0; t < state_->lanes.taxels; ++t)
    if (!state_->lanes.patterns[t].x.empty()) state_->start_lane(t, true);
}

template <class Real>
FrameCompensator<Real>::FrameCompensator(const FrameSetup& setup) : state_(std::make_unique<State>(setup)) {}
template <class Real>
FrameCompensator<Real>::~FrameCompensator() = default;
template <class Real>
FrameCompensator<Real>::FrameCompensator(FrameCompensator&&) noexcept = default;
template <class Real>
FrameCompensator<Real>& FrameCompensator<Real>::operator=(FrameCompensator&&) noexcept = default;

template <class Real>
std::size_t FrameCompensator<Real>::taxels() const {
  return state_->lanes.taxels;
}
template <class Real>
void FrameCompensator<Real>::set_outside_validity(bool outside) {
  state_->outside = outside;
}
template <class Real>
void FrameCompensator<Real>::set_dispatch(Dispatch dispatch) {
  state_->dispatch = std::min(dispatch, best_dispatch());
}
template <class Real>
Dispatch FrameCompensator<Real>::dispatch() const {
  return state_->dispatch;
}

template class FrameCompensator<float>;
template class FrameCompensator<double>;

}  // namespace tactbench::analysis
