#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/compensate/frame_state.h"

namespace tactbench::analysis {

namespace {

constexpr double kNoSample = 1e15;  // a mean that any sample is far from

template <class Real, class Sample>
void run_pass(FrameLanes<Real>& lanes, const Sample* samples, const FrameResults<Real>& results, Dispatch dispatch) {
  using Passes = FramePasses<Real, Sample>;
  const FramePass<Real, Sample> pass = dispatch == Dispatch::kAvx512 ? &Passes::avx512
                                       : dispatch == Dispatch::kAvx2 ? &Passes::avx2
                                                                     : &Passes::base;
  pass(lanes, samples, results);
}

}  // namespace

template <class Real>
typename FrameCompensator<Real>::State::Place FrameCompensator<Real>::State::place(std::size_t taxel) {
  return {taxel, taxel % kLanes, lanes.blocks[taxel / kLanes], taxels[taxel], patterns[taxel]};
}

template <class Real>
void FrameCompensator<Real>::State::take_extreme(const Place& at) {
  LaneBlock<Real>& b = at.b;
  const std::size_t i = at.i;
  b.extreme[i] = b.mean[i];
  b.extreme_weight[i] = b.weight[i];
  b.turn[i] = b.mean[i] - lanes.limits.lead_of(b.weight[i], std::sqrt(b.weight[i]));
}

template <class Real>
void FrameCompensator<Real>::State::face(const Place& at, bool rising) {
  if (at.t.rises == rising) return;
  at.t.rises = rising;
  LaneBlock<Real>& b = at.b;
  for (Real* const row : {b.gain, b.mean, b.extreme, b.turn, b.lowest, b.highest}) row[at.i] = -row[at.i];
  std::swap(b.lowest[at.i], b.highest[at.i]);
}

// The next sample searches for its piece.
template <class Real>
void FrameCompensator<Real>::State::set_curve(const Place& at, const ComposedCurve& curve) {
  constexpr Real kUnfilled = std::numeric_limits<Real>::quiet_NaN();
  face(at, curve.ascending);
  at.t.curve = curve;
  at.t.back_turn = kUnfilled;
  constexpr auto kNowhere = static_cast<Real>(kFar);
  for (LanePiece& piece : at.t.pieces) {
    piece.low = kNowhere;
    piece.high = -kNowhere;
    piece.piece = {kFar, -kFar};
  }
  std::fill_n(sensitivities_of(at.taxel), knots + 3, Sensitivity{kUnfilled, kUnfilled});
  at.b.low[at.i] = kNowhere;
  at.b.high[at.i] = -kNowhere;
}

template <class Real>
void FrameCompensator<Real>::State::start_lane(std::size_t taxel, bool unknown) {
  const Place at = place(taxel);
  LaneBlock<Real>& b = at.b;
  const std::size_t i = at.i;
  const double x0 = at.pattern.x.front(), xu = at.pattern.x.back();
  at.t.unknown = unknown;
  set_curve(at, curve_from(at.pattern, true, x0, 0.0, x0));
  b.steps[i] = static_cast<Real>(kStepCeiling);
  b.weight[i] = b.extreme_weight[i] = Real(1);
  b.turn[i] = b.extreme[i] = Real(0);
  b.mean[i] = unknown ? static_cast<Real>(kNoSample) : Real(0);
  b.pressure[i] = static_cast<Real>(x0);
  b.uncertainty[i] = std::sqrt(static_cast<Real>(unknown ? span_psi * span_psi : 0.0) + residual2_at(at, x0));
  if (!unknown) return;
  histories[taxel] = {};
  histories[taxel].other = curve_from(at.pattern, false, xu, at.pattern.span, xu);
  // Not known: an event in each frame.
  b.own[i] = b.worst[i] = std::numeric_limits<Real>::quiet_NaN();
}

template <class Real>
void FrameCompensator<Real>::State::mark(const Output& output) const {
  if (outside)
    for (std::uint16_t& bits : output.status) bits = static_cast<std::uint16_t>((bits & ~kTaxelValid) | kTaxelOutside);
  for (const std::size_t taxel : dead) {
    output.pressure_psi[taxel] = static_cast<Real>(lowest_psi);
    output.uncertainty_psi[taxel] = static_cast<Real>(span_psi);
    output.status[taxel] = kTaxelDead;
  }
}

template <class Real>
void FrameCompensator<Real>::State::mark_lost(const Output& output) const {
  const int lost = kTaxelLost | (outside ? kTaxelOutside : 0);
  for (std::size_t taxel = 0; taxel < count; ++taxel)
    if ((lanes.bits.lost[taxel / kLanes] >> taxel % kLanes & 1) != 0 && output.status[taxel] != kTaxelDead)
      output.status[taxel] = static_cast<std::uint16_t>(lost | (taxels[taxel].unknown ? kTaxelUnknown : 0));
}

template <class Real>
void FrameCompensator<Real>::State::check(std::size_t samples, const Output& output) const {
  if (samples != count || output.pressure_psi.size() != count || output.uncertainty_psi.size() != count ||
      output.status.size() != count)
    throw std::invalid_argument(
        "frame compensator: the number of samples or of an output's values is not that of the taxels");
}

template <class Real>
template <class Sample>
void FrameCompensator<Real>::State::frame(std::span<const Sample> samples, AlignedVector<Sample>& whole_blocks,
                                          const Output& output) {
  check(samples.size(), output);
  const bool whole = count % kLanes == 0;
  if (!whole) std::ranges::copy(samples, whole_blocks.begin());
  const FrameResults<Real> results =
      whole ? FrameResults<Real>{output.pressure_psi.data(), output.uncertainty_psi.data(), output.status.data()}
            : FrameResults<Real>{pressures.data(), uncertainties.data(), status.data()};
  run_pass(lanes, whole ? samples.data() : whole_blocks.data(), results, dispatch);
  attend(results);
  if (!whole) {
    std::copy_n(pressures.begin(), count, output.pressure_psi.begin());
    std::copy_n(uncertainties.begin(), count, output.uncertainty_psi.begin());
    std::copy_n(status.begin(), count, output.status.begin());
  }
  mark(output);
  gap = 0;
}

template <class Real>
void FrameCompensator<Real>::frame(std::span<const std::uint16_t> counts, const Output& output) {
  state_->frame(counts, state_->counts, output);
}

template <class Real>
void FrameCompensator<Real>::frame(std::span<const Real> volts, const Output& output) {
  state_->frame(volts, state_->volts, output);
  state_->mark_lost(output);
}

template <class Real>
void FrameCompensator<Real>::lost_frame(const Output& output) {
  State& s = *state_;
  s.check(s.count, output);
  if (++s.gap > s.longest_gap) reset_unknown();
  // The next sample is taken as it comes: the output may have gone anywhere meanwhile.
  for (LaneBlock<Real>& b : s.lanes.blocks) std::fill_n(b.steps, kLanes, static_cast<Real>(kStepCeiling));
  for (std::size_t taxel = 0; taxel < s.count; ++taxel) {
    output.pressure_psi[taxel] = s.lanes.blocks[taxel / kLanes].pressure[taxel % kLanes];
    output.uncertainty_psi[taxel] = s.lanes.blocks[taxel / kLanes].uncertainty[taxel % kLanes];
  }
  std::ranges::fill(s.lanes.bits.lost, std::uint16_t{0xFFFF});
  s.mark(output);
  s.mark_lost(output);
}

template <class Real>
std::size_t FrameCompensator<Real>::tare(std::span<const std::uint16_t> counts) {
  State& s = *state_;
  if (counts.size() != s.count)
    throw std::invalid_argument("frame compensator: the number of samples is not that of the taxels");
  std::size_t refused = 0;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (s.patterns[t].x.empty()) continue;
    LaneBlock<Real>& b = s.lanes.blocks[t / kLanes];
    const std::size_t i = t % kLanes;
    const Real moved = b.gain[i] * (static_cast<Real>(counts[t]) - b.zero[i]);
    const bool small = std::abs(static_cast<double>(moved)) <= s.tare_share * s.patterns[t].span;
    if (small) b.zero[i] = static_cast<Real>(counts[t]);
    refused += small ? 0 : 1;
    s.start_lane(t, !small);
  }
  return refused;
}

template <class Real>
void FrameCompensator<Real>::reset() {
  for (std::size_t t = 0; t < state_->count; ++t)
    if (!state_->patterns[t].x.empty()) state_->start_lane(t, false);
}

template <class Real>
void FrameCompensator<Real>::reset_unknown() {
  for (std::size_t t = 0; t < state_->count; ++t)
    if (!state_->patterns[t].x.empty()) state_->start_lane(t, true);
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
  return state_->count;
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
