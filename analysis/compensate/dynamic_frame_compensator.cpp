#include "analysis/compensate/dynamic_frame_compensator.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/compensate/dynamic_frame_state.h"

namespace tactbench::analysis {

template <class Real>
void DynamicFrameCompensator<Real>::State::start(std::size_t taxel, bool is_unknown) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  constexpr auto kMany = static_cast<Real>(1e15);  // a mean that any sample is far from
  set_unknown(t, is_unknown);
  t.started = t.decided = !is_unknown;
  t.first = 0;
  t.first_weight = 1;
  t.highest = 0;
  t.gain = 1;
  const auto share = static_cast<Real>(observer.share);
  t.top_from = share > Real(0) ? (Real(1) - share) * t.top : std::numeric_limits<Real>::max();
  t.back_known = false;
  t.memory.start_low(Real(0));
  b.gain[i] = t.plain_gain;
  b.rising[i] = 1;
  b.steps[i] = static_cast<Real>(kStepCeiling);
  b.mean[i] = is_unknown ? kMany : Real(0);
  b.weight[i] = b.extreme_weight[i] = 1;
  b.extreme[i] = b.turn[i] = 0;
  for (std::size_t j = 0; j < kCreepElements; ++j) b.psi[j][i] = static_cast<Real>(begin.psi[j]);
  b.late[i] = b.last_x[i] = b.last_slope[i] = b.last_mean[i] = 0;
  b.last_share[i] = 1;  // of no account until a reading has a slope
  b.pressure[i] = shared.lowest;
  b.uncertainty[i] = is_unknown ? shared.span : Real(0);
  b.residual[i] = b.doubted[i] = 0;
  // Nothing holds: an event in the next frame, of an unknown history in each.
  b.low[i] = std::numeric_limits<Real>::max();
  b.high[i] = -std::numeric_limits<Real>::max();
  b.u[i] = b.x[i] = b.slope[i] = 0;
  b.reverse[i] = std::numeric_limits<Real>::quiet_NaN();
  if (is_unknown) t.other.start_high(everett(taxel), Real(0));
}

template <class Real>
void DynamicFrameCompensator<Real>::State::set_step(double seconds) {
  const DynamicsStep step(dynamics, seconds);
  interval_s = seconds;
  shared.creep_new = shared.creep_all = 0;
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    const double k = dynamics.creep_share[j];
    shared.creep_new += static_cast<Real>(k * (1.0 - step.creep[j]));
    shared.creep_all += static_cast<Real>(k);
    shared.creep_kept[j] = static_cast<Real>(k * step.creep[j]);
    shared.kept[j] = static_cast<Real>(step.creep[j]);
  }
  shared.lag_kept = static_cast<Real>(step.lag);
}

template <class Real>
void DynamicFrameCompensator<Real>::State::check(std::size_t size, const Output& output) const {
  if (size != count || output.pressure_psi.size() != count || output.uncertainty_psi.size() != count ||
      output.status.size() != count)
    throw std::invalid_argument(
        "dynamic frame compensator: the number of samples or of an output's values is not that of the taxels");
}

template <class Real>
void DynamicFrameCompensator<Real>::State::mark(const Output& output) {
  for (std::size_t k = 0; k < blocks.size(); ++k)
    for (std::size_t taxel = k * kLanes; lost[k] != 0 && taxel < std::min(count, (k + 1) * kLanes); ++taxel)
      if ((lost[k] >> taxel % kLanes & 1U) != 0) output.status[taxel] = kTaxelLost;
  for (std::size_t taxel = 0; unknowns != 0 && taxel < count; ++taxel)
    if (taxels[taxel].unknown) output.status[taxel] |= kTaxelUnknown;
  if (outside)
    for (std::uint16_t& bits : output.status) bits = static_cast<std::uint16_t>((bits & ~kTaxelValid) | kTaxelOutside);
  for (const std::size_t taxel : dead) {
    output.pressure_psi[taxel] = shared.lowest;
    output.uncertainty_psi[taxel] = shared.span;
    output.status[taxel] = kTaxelDead;
  }
}

template <class Real>
template <class Sample>
void DynamicFrameCompensator<Real>::State::frame(std::span<const Sample> from, const Output& output) {
  check(from.size(), output);
  bool any_lost = false;
  std::ranges::fill(lost, std::uint16_t{0});
  for (std::size_t taxel = 0; taxel < count; ++taxel) {
    if constexpr (std::is_integral_v<Sample>) {
      samples[taxel] = static_cast<Real>(from[taxel]);
    } else {
      const Real counts = from[taxel] * counts_per_volt;
      const bool number = std::abs(counts) <= static_cast<Real>(kMostOutput);
      samples[taxel] = number ? counts : Real(0);
      if (number) continue;
      any_lost = true;
      lost[taxel / kLanes] |= static_cast<std::uint16_t>(1U << taxel % kLanes);
    }
  }
  using Passes = DynamicPasses<Real>;
  const bool wide = dispatch == Dispatch::kAvx512, avx = dispatch == Dispatch::kAvx2;
  const auto pass = wide ? &Passes::avx512 : avx ? &Passes::avx2 : &Passes::base;
  const auto finish = wide ? &Passes::finish_avx512 : avx ? &Passes::finish_avx2 : &Passes::finish_base;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    const std::size_t at = k * kLanes;
    if (any_lost && lost[k] != 0) kept = blocks[k];
    const unsigned events = pass(blocks[k], &samples[at], shared, &outputs[at], marks);
    if (any_lost && lost[k] != 0) {
      auto* const rows = reinterpret_cast<Real*>(&blocks[k]);
      const auto* const before = reinterpret_cast<const Real*>(&kept);
      for (std::size_t i = 0; i < sizeof(kept) / sizeof(Real); ++i)
        if ((lost[k] >> i % kLanes & 1U) != 0) rows[i] = before[i];
    }
    if (events != 0) attend(k, events);
    const FrameResults<Real> to =
        at + kLanes <= count
            ? FrameResults<Real>{&output.pressure_psi[at], &output.uncertainty_psi[at], &output.status[at]}
            : FrameResults<Real>{pressures.data(), uncertainties.data(), status.data()};
    finish(blocks[k], shared, &outputs[at], to);
    for (unsigned left = lost[k]; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      to.pressure[i] = blocks[k].pressure[i] = kept.pressure[i];
    }
    if (at + kLanes > count) {
      std::copy_n(pressures.begin(), count - at, output.pressure_psi.begin() + at);
      std::copy_n(uncertainties.begin(), count - at, output.uncertainty_psi.begin() + at);
      std::copy_n(status.begin(), count - at, output.status.begin() + at);
    }
  }
  mark(output);
  gap = 0;
}

template <class Real>
void DynamicFrameCompensator<Real>::frame(std::span<const std::uint16_t> counts, const Output& output) {
  state_->frame(counts, output);
}

template <class Real>
void DynamicFrameCompensator<Real>::frame(std::span<const Real> volts, const Output& output) {
  state_->frame(volts, output);
}

template <class Real>
void DynamicFrameCompensator<Real>::lost_frame(const Output& output) {
  State& s = *state_;
  s.check(s.count, output);
  if (++s.gap > s.longest_gap) reset_unknown();
  std::ranges::fill(s.lost, std::uint16_t{0xFFFF});
  for (std::size_t taxel = 0; taxel < s.count; ++taxel) {
    DynamicBlock<Real>& b = s.block(taxel);
    const std::size_t i = taxel % kLanes;
    output.pressure_psi[taxel] = b.pressure[i];
    output.uncertainty_psi[taxel] =
        std::min(std::sqrt(b.uncertainty[i] * b.uncertainty[i] + b.residual[i] * b.residual[i]), s.shared.span);
    b.steps[i] = static_cast<Real>(kStepCeiling);  // the next sample is taken as it comes
    // Creep and lag go on at the last pressure.
    const Real p = b.pressure[i] - s.shared.lowest, target = p / (p + s.shared.half);
    for (std::size_t j = 0; j < kCreepElements; ++j) b.psi[j][i] = target + (b.psi[j][i] - target) * s.shared.kept[j];
    b.late[i] = p + (b.late[i] - p) * s.shared.lag_kept;
  }
  s.mark(output);
}

template <class Real>
std::size_t DynamicFrameCompensator<Real>::tare(std::span<const std::uint16_t> counts) {
  State& s = *state_;
  if (counts.size() != s.count)
    throw std::invalid_argument("dynamic frame compensator: the number of samples is not that of the taxels");
  std::size_t refused = 0;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (!s.taxels[t].usable) continue;
    DynamicBlock<Real>& b = s.block(t);
    const std::size_t i = t % kLanes;
    const Real moved = s.taxels[t].plain_gain * (static_cast<Real>(counts[t]) - b.zero[i]);
    const bool small = std::abs(static_cast<double>(moved)) <= s.tare_share * static_cast<double>(s.taxels[t].top);
    if (small) b.zero[i] = static_cast<Real>(counts[t]);
    refused += small ? 0 : 1;
    s.start(t, !small);
  }
  return refused;
}

template <class Real>
void DynamicFrameCompensator<Real>::reset() {
  for (std::size_t t = 0; t < state_->count; ++t)
    if (state_->taxels[t].usable) state_->start(t, false);
}
template <class Real>
void DynamicFrameCompensator<Real>::reset_unknown() {
  for (std::size_t t = 0; t < state_->count; ++t)
    if (state_->taxels[t].usable) state_->start(t, true);
}

template <class Real>
void DynamicFrameCompensator<Real>::set_interval(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0.0)
    throw std::invalid_argument("dynamic frame compensator: the interval is negative or not a finite number");
  if (seconds != state_->interval_s) state_->set_step(seconds);
}

template <class Real>
DynamicFrameCompensator<Real>::DynamicFrameCompensator(const DynamicSetup& setup)
    : state_(std::make_unique<State>(setup)) {}
template <class Real>
DynamicFrameCompensator<Real>::~DynamicFrameCompensator() = default;
template <class Real>
DynamicFrameCompensator<Real>::DynamicFrameCompensator(DynamicFrameCompensator&&) noexcept = default;
template <class Real>
DynamicFrameCompensator<Real>& DynamicFrameCompensator<Real>::operator=(DynamicFrameCompensator&&) noexcept = default;

template <class Real>
std::size_t DynamicFrameCompensator<Real>::taxels() const {
  return state_->count;
}
template <class Real>
void DynamicFrameCompensator<Real>::set_outside_validity(bool outside) {
  state_->outside = outside;
}
template <class Real>
void DynamicFrameCompensator<Real>::set_dispatch(Dispatch dispatch) {
  state_->dispatch = std::min(dispatch, best_dispatch());
}
template <class Real>
Dispatch DynamicFrameCompensator<Real>::dispatch() const {
  return state_->dispatch;
}
template <class Real>
std::size_t DynamicFrameCompensator<Real>::bytes_per_taxel() const {
  const std::size_t lane = (sizeof(DynamicBlock<Real>) / kLanes) + 2 * sizeof(Real);
  return lane + sizeof(typename State::Taxel) + state_->table_size * sizeof(Real);
}

template class DynamicFrameCompensator<float>;
template class DynamicFrameCompensator<double>;

}  // namespace tactbench::analysis
