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
  demand(up.size() == knots && down.size() == knots, "its patterns and the pressures differ in number");
  demand(up.front() == down.front() && up.back() == down.back(), "its patterns do not meet at their ends");
  const ElamParameters& p = taxel.parameters;
  for (const double value : {p.alpha_d, p.beta_d, p.beta_a})
    demand(value >= 0.0 && value <= 1.0, "alpha_d, beta_d or beta_a is not within 0 and 1");
  demand(std::isfinite(p.alpha_a1) && std::isfinite(p.alpha_a0), "alpha_a1 or alpha_a0 is not a finite number");
  demand(std::abs(up.front()) <= kMostOutput * setup.volts_per_count, "its zero is beyond 1e12 counts");
  demand(std::isfinite(taxel.noise_v) && taxel.noise_v >= 0.0, "its noise is negative or not a finite number");
  for (const double residual : taxel.residual_psi)
    demand(residual >= 0.0 && residual <= kMostPressure, "its residual is not within 0 and 1e9");
  TaxelPattern pattern;
  pattern.x = setup.pressure_psi;
  pattern.ascending = side_of(PatternCurve(setup.pressure_psi, up, up.front(), up.back()), noise_v);
  pattern.descending = side_of(PatternCurve(setup.pressure_psi, down, down.front(), down.back()), noise_v);
  pattern.parameters = p;
  pattern.exact_outer = setup.elam.exact_outer;
  pattern.noise_v = noise_v;
  pattern.span = pattern.ascending.y.back();
  demand(pattern.span >= kLeastOutput && pattern.span <= kMostOutput,
         "its full output is not within 1e-3 and 1e12 of its noise");
  pattern.drift = setup.options.drift_share * pattern.span;
  pattern.step = setup.options.flat_in_noises;
  pattern.saturated = kSaturatedShare * pattern.span;
  return pattern;
}

}  // namespace

template <class Real>
FrameLimits<Real>::FrameLimits(const CompensatorOptions& o, double volts_per_count)
    : moving(static_cast<Real>(o.moving)),
      jump2(static_cast<Real>(o.jump_in_noises * o.jump_in_noises)),
      least(static_cast<Real>(1.0 / o.longest_mean)),
      band2(static_cast<Real>(o.band_in_noises * o.band_in_noises)),
      rest2(static_cast<Real>(o.rest_in_noises * o.rest_in_noises)),
      hold2(static_cast<Real>(o.hold_in_noises * o.hold_in_noises)),
      lead(static_cast<Real>(o.lead_in_noises)),
      flat(static_cast<Real>(o.flat_psi / o.flat_in_noises)),
      counts_per_volt(static_cast<Real>(1.0 / volts_per_count)) {
  Real weight = 1;
  for (std::size_t samples = 1; samples <= 8; ++samples) {
    const Real next = std::max(weight / (Real(1) + weight), least), root = std::sqrt(next);
    for (const std::size_t i : {samples, samples % 8}) {
      jumps2[i] = jump2 * (Real(1) + weight);
      step_weights[i] = Real(1) - Real(0.5) * weight;
      next_weights[i] = next;
      next_roots[i] = root;
      next_leads[i] = lead_of(next, root);
    }
    has_tables = weight <= least;  // else some means have more than 8
    weight = next;
  }
}

template <class Real>
FrameCompensator<Real>::State::State(const FrameSetup& setup) {
  check_options(setup.options);
  demand(setup.pressure_psi.size() >= 2, "fewer than two pressures");
  demand(!setup.taxels.empty(), "no taxels");
  demand(setup.volts_per_count >= 1.0 / kMostOutput && setup.volts_per_count <= kMostOutput,
         "volts_per_count is not within 1e-12 and 1e12");
  demand(setup.longest_gap >= 0 && setup.tare_share >= 0.0, "longest_gap or tare_share is negative");
  for (std::size_t i = 0; i < setup.pressure_psi.size(); ++i)
    demand(std::abs(setup.pressure_psi[i]) <= kMostPressure &&
               (i == 0 || setup.pressure_psi[i] - setup.pressure_psi[i - 1] >= kLeastSpan),
           "pressures do not increase by 1e-9 each, or one is beyond 1e9");
  count = setup.taxels.size();
  knots = setup.pressure_psi.size();
  options = setup.options;
  options.hold_in_noises = std::min(setup.options.hold_in_noises, setup.options.band_in_noises);
  lowest_psi = setup.pressure_psi.front();
  span_psi = setup.pressure_psi.back() - lowest_psi;
  for (const TaxelSetup& taxel : setup.taxels)
    if (taxel.usable) residual_size = std::max(residual_size, taxel.residual_psi.size());
  residuals2.assign(residual_size * count, Real(0));
  tare_share = setup.tare_share;
  longest_gap = setup.longest_gap;
  dispatch = best_dispatch();
  const std::size_t blocks = (count + kLanes - 1) / kLanes, padded = blocks * kLanes;
  lanes.limits = FrameLimits<Real>(options, setup.volts_per_count);
  lanes.blocks.assign(blocks, LaneBlock<Real>{});
  for (std::vector<std::uint16_t>* const bits : {&lanes.bits.events, &lanes.bits.held, &lanes.bits.lost})
    bits->assign((blocks + 3) / 4 * 4, 0);
  patterns.resize(count);
  taxels.resize(count);
  sensitivities.resize(count * (knots + 3));
  histories.resize(count);
  counts.resize(padded);
  volts.resize(padded);
  pressures.resize(padded);
  uncertainties.resize(padded);
  status.resize(padded);
  for (std::size_t t = 0; t < padded; ++t) {
    LaneBlock<Real>& b = lanes.blocks[t / kLanes];
    const std::size_t i = t % kLanes;
    // A lane without a taxel: no sample of it is an event.
    b.weight[i] = b.extreme_weight[i] = Real(1);
    b.low[i] = static_cast<Real>(-kFar);
    b.high[i] = static_cast<Real>(kFar);
    b.at[i] = static_cast<Real>(lowest_psi);
    if (t >= count) continue;
    const TaxelSetup& taxel = setup.taxels[t];
    if (!taxel.usable) {
      dead.push_back(t);
      continue;
    }
    // Half a count of rounding is noise, too, and the least possible.
    const double noise = std::hypot(taxel.noise_v, setup.volts_per_count / std::sqrt(12.0));
    try {
      patterns[t] = pattern_of(setup, taxel, noise);
      const std::vector<double>& own = taxel.residual_psi;
      demand(own.empty() || (own.size() == residual_size && residual_size % 2 == 0),
             "its residual is not of as many levels as the others', rising and falling");
      std::ranges::transform(own, residuals2.begin() + static_cast<std::ptrdiff_t>(t * residual_size),
                             [](double psi) { return static_cast<Real>(psi * psi); });
    } catch (const std::invalid_argument& fault) {
      throw std::invalid_argument("taxel " + std::to_string(t) + ": " + fault.what());
    }
    const double sign = taxel.falling ? -1.0 : 1.0;
    b.gain[i] = static_cast<Real>(sign * setup.volts_per_count / noise);
    b.zero[i] = static_cast<Real>(sign * taxel.ascending_v.front() / setup.volts_per_count);
    b.lowest[i] = static_cast<Real>(-options.band_in_noises);
    b.highest[i] = static_cast<Real>(patterns[t].span + options.band_in_noises);
    start_lane(t, setup.start_unknown);
  }
}

template struct FrameCompensator<float>::State;
template struct FrameCompensator<double>::State;

}  // namespace tactbench::analysis
