#include "analysis/compensate/frame_compensator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "analysis/compensate/frame_state.h"

namespace tactbench::analysis {

namespace {

void demand(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("frame compensator: " + what);
}

TaxelPattern::Side side_of(const PatternCurve& curve, double noise_v) {
  TaxelPattern::Side side;
  const auto x = curve.x(), y = curve.y();
  for (std::size_t i = 0; i < y.size(); ++i) side.y.push_back((y[i] - y.front()) / noise_v);
  for (std::size_t i = 0; i + 1 < y.size(); ++i) side.slope.push_back(noise_v * (x[i + 1] - x[i]) / (y[i + 1] - y[i]));
  return side;
}

TaxelPattern pattern_of(const FrameSetup& setup, const TaxelSetup& taxel, double noise_v) {
  const std::vector<double>&up = taxel.ascending_v, &down = taxel.descending_v;
  const std::size_t knots = setup.pressure_psi.size();
  demand(up.size() == knots && down.size() == knots, "its patterns have not as many values as there are pressures");
  demand(up.front() == down.front() && up.back() == down.back(), "its patterns do not meet at their ends");
  const ElamParameters& p = taxel.parameters;
  for (const double value : {p.alpha_d, p.beta_d, p.beta_a})
    demand(value >= 0.0 && value <= 1.0, "alpha_d, beta_d or beta_a is not within 0 and 1");
  demand(std::isfinite(p.alpha_a1) && std::isfinite(p.alpha_a0), "alpha_a1 or alpha_a0 is not a finite number");
  demand(std::isfinite(taxel.noise_v) && taxel.noise_v >= 0.0, "its noise is negative or not a finite number");
  TaxelPattern pattern;
  pattern.x = setup.pressure_psi;
  pattern.ascending = side_of(PatternCurve(setup.pressure_psi, up, up.front(), up.back()), noise_v);
  pattern.descending = side_of(PatternCurve(setup.pressure_psi, down, down.front(), down.back()), noise_v);
  pattern.parameters = p;
  pattern.exact_outer = setup.elam.exact_outer;
  pattern.noise_v = noise_v;
  pattern.span = pattern.ascending.y.back();
  pattern.drift = setup.options.drift_share * pattern.span;
  pattern.step = setup.options.flat_in_noises;
  pattern.saturated = kSaturatedShare * pattern.span;
  return pattern;
}

}  // namespace

const char* to_string(Dispatch dispatch) { return dispatch == Dispatch::kAvx2 ? "avx2" : "base"; }

Dispatch best_dispatch() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return Dispatch::kAvx2;
#endif
  return Dispatch::kBase;
}

template <class Real>
FrameCompensator<Real>::State::State(const FrameSetup& setup) {
  check_options(setup.options);
  demand(setup.pressure_psi.size() >= 2, "fewer than two pressures");
  demand(!setup.taxels.empty(), "no taxels");
  demand(std::isfinite(setup.volts_per_count) && setup.volts_per_count > 0.0, "volts_per_count is not positive");
  demand(setup.longest_gap >= 0 && setup.tare_share >= 0.0, "longest_gap or tare_share is negative");
  for (std::size_t i = 0; i < setup.pressure_psi.size(); ++i)
    demand(std::isfinite(setup.pressure_psi[i]) && (i == 0 || setup.pressure_psi[i] > setup.pressure_psi[i - 1]),
           "pressures do not increase");
  const std::size_t count = setup.taxels.size(), padded = (count + kLanes - 1) / kLanes * kLanes;
  lanes.options = setup.options;
  lanes.options.hold_in_noises = std::min(setup.options.hold_in_noises, setup.options.band_in_noises);
  lanes.counts_per_volt = 1.0 / setup.volts_per_count;
  lanes.taxels = count;
  lanes.knots = setup.pressure_psi.size();
  lanes.blocks.assign(padded / kLanes, LaneBlock<Real>{});
  lowest_psi = setup.pressure_psi.front();
  span_psi = setup.pressure_psi.back() - lowest_psi;
  lanes.pieces.assign(padded, 0);
  lanes.former.resize(count);
  lanes.sensitivities.resize(count * (lanes.knots + 3));
  lanes.events.resize(padded);
  lanes.patterns.resize(count);
  lanes.curves.resize(count);
  ways_back.resize(count);
  histories.resize(count);
  counts.resize(padded);
  volts.resize(padded);
  saved.reserve(count);
  lost.assign(count, false);
  tare_share = setup.tare_share;
  longest_gap = setup.longest_gap;
  dispatch = best_dispatch();
  for (std::size_t t = 0; t < padded; ++t) {
    LaneBlock<Real>& b = lanes.block(t);
    const std::size_t i = t % kLanes;
    // A lane without a taxel: nothing that it reads is an event.
    b.weight[i] = b.root_weight[i] = b.extreme_weight[i] = Real(1);
    b.from[i] = static_cast<Real>(-kFar);
    b.to[i] = static_cast<Real>(kFar);
    b.at[i] = static_cast<Real>(lowest_psi);
    if (t >= count) continue;
    const TaxelSetup& taxel = setup.taxels[t];
    if (!taxel.usable) {
      dead.push_back(t);
      continue;
    }
    // Half a count of rounding is noise, too, and the least there is.
    const double noise = std::hypot(taxel.noise_v, setup.volts_per_count / std::sqrt(12.0));
    try {
      lanes.patterns[t] = pattern_of(setup, taxel, noise);
    } catch (const std::invalid_argument& fault) {
      throw std::invalid_argument("taxel " + std::to_string(t) + ": " + fault.what());
    }
    const double sign = taxel.falling ? -1.0 : 1.0;
    b.gain[i] = static_cast<Real>(sign * setup.volts_per_count / noise);
    b.zero[i] = static_cast<Real>(sign * taxel.ascending_v.front() / setup.volts_per_count);
    b.highest[i] = static_cast<Real>(lanes.patterns[t].span + setup.options.band_in_noises);
    start_lane(t, setup.start_unknown);
  }
}

template struct FrameCompensator<float>::State;
template struct FrameCompensator<double>::State;

}  // namespace tactbench::analysis
