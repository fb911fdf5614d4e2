#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "analysis/compensate/dynamic_frame_state.h"

namespace tactbench::analysis {

namespace {

void demand(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("dynamic frame compensator: " + what);
}

}  // namespace

template <class Real>
DynamicFrameCompensator<Real>::State::State(const DynamicSetup& setup) {
  check_setup(setup);
  demand(!setup.taxels.empty(), "no taxels");
  demand(setup.volts_per_count >= 1.0 / kMostOutput && setup.volts_per_count <= kMostOutput,
         "volts_per_count is not within 1e-12 and 1e12");
  demand(setup.longest_gap >= 0 && setup.tare_share >= 0.0, "longest_gap or tare_share is negative");
  count = setup.taxels.size();
  intervals = setup.intervals;
  table_size = Everett<Real>::size(intervals);
  demand(count <= std::numeric_limits<std::int32_t>::max() / table_size, "too many taxels");
  for (const double residual : setup.residual_psi) residuals.push_back(static_cast<Real>(residual));
  dynamics = setup.dynamics;
  work_unseen(dynamics, begin, setup.worked_s, setup.x_high - setup.x_low);
  options = setup.options;
  options.hold_in_noises = std::min(options.hold_in_noises, options.band_in_noises);
  observer = setup.observer;
  tare_share = setup.tare_share;
  longest_gap = setup.longest_gap;
  dispatch = best_dispatch();
  counts_per_volt = static_cast<Real>(1.0 / setup.volts_per_count);
  per_interval = static_cast<Real>((setup.x_high - setup.x_low) / static_cast<double>(intervals));
  intervals_per = Real(1) / per_interval;
  const auto square = [](double value) { return static_cast<Real>(value * value); };
  shared.moving = static_cast<Real>(options.moving);
  shared.jump2 = square(options.jump_in_noises);
  shared.least = static_cast<Real>(1.0 / options.longest_mean);
  shared.band2 = square(options.band_in_noises);
  shared.rest2 = square(options.rest_in_noises);
  shared.hold2 = square(options.hold_in_noises);
  shared.lead = static_cast<Real>(options.lead_in_noises);
  shared.band = static_cast<Real>(options.band_in_noises);
  // Flat when an output so many noises off moves the estimate by more than flat_psi.
  shared.flat = options.flat_in_noises > 0.0 ? static_cast<Real>(options.flat_psi / options.flat_in_noises)
                                             : std::numeric_limits<Real>::max();
  shared.half = static_cast<Real>(dynamics.creep_half);
  shared.span = static_cast<Real>(setup.x_high - setup.x_low);
  shared.lowest = static_cast<Real>(setup.x_low);
  set_step(0.0);
  const std::size_t whole = (count + kLanes - 1) / kLanes;
  blocks.assign(whole, DynamicBlock<Real>{});
  samples.assign(whole * kLanes, Real(0));
  outputs.assign(whole * kLanes, Real(0));
  pressures.assign(kLanes, Real(0));
  uncertainties.assign(kLanes, Real(0));
  status.assign(kLanes, std::uint16_t{0});
  lost.assign(whole, std::uint16_t{0});
  taxels.resize(count);
  tables.assign(count * table_size, Real(0));
  const auto n = static_cast<std::uint32_t>(intervals);
  searched = {tables.data(),
              residuals.empty() ? nullptr : residuals.data(),
              static_cast<std::int32_t>(n),
              static_cast<std::int32_t>(std::bit_floor(n)),
              per_interval,
              shared.span};
  for (std::size_t t = 0; t < whole * kLanes; ++t) {
    DynamicBlock<Real>& b = blocks[t / kLanes];
    const std::size_t i = t % kLanes;
    // A lane without a taxel: no sample of it is an event.
    b.rising[i] = b.weight[i] = b.extreme_weight[i] = 1;
    b.low[i] = -std::numeric_limits<Real>::max();
    b.high[i] = b.highest[i] = std::numeric_limits<Real>::max();
    if (t >= count) continue;
    const DynamicTaxel& taxel = setup.taxels[t];
    if (!taxel.usable) {
      dead.push_back(t);
      continue;
    }
    // Half a count of rounding is noise, too, and the least possible.
    const double noise = std::hypot(taxel.noise_v, setup.volts_per_count / std::sqrt(12.0));
    double top = 0.0;
    try {
      check_taxel(setup, taxel);
      top = Divider{0.0, taxel.divider.per_amplitude}.output(taxel.everett[table_size - 1 - intervals]);
      demand(top >= kLeastOutput * noise && taxel.everett[table_size - 1 - intervals] <= kMostOutput * noise,
             "its full output is not within 1e-3 and 1e12 of its noise");
      demand(std::abs(taxel.divider.zero) <= kMostOutput * setup.volts_per_count, "its zero is beyond 1e12 counts");
    } catch (const std::invalid_argument& fault) {
      throw std::invalid_argument("taxel " + std::to_string(t) + ": " + fault.what());
    }
    const double sign = taxel.falling ? -1.0 : 1.0;
    Taxel& own = taxels[t];
    own.usable = true;
    own.plain_gain = static_cast<Real>(sign * setup.volts_per_count / noise);
    for (std::size_t k = 0; k < table_size; ++k)
      tables[t * table_size + k] = static_cast<Real>(taxel.everett[k] / noise);
    own.top = static_cast<Real>(top / noise);
    b.zero[i] = static_cast<Real>(sign * taxel.divider.zero / setup.volts_per_count);
    b.divider[i] = static_cast<Real>(taxel.divider.per_amplitude * noise);
    b.highest[i] = own.top + shared.band;
    b.steepest[i] = static_cast<Real>(kSteepestGuess) * shared.span / own.top;
    b.creep_scale[i] = static_cast<Real>(taxel.creep_scale);
    b.residual_scale[i] = static_cast<Real>(taxel.residual_scale);
    b.lag_share[i] = static_cast<Real>(taxel.lag_share);
    start(t, setup.start_unknown);
  }
}

template struct DynamicFrameCompensator<float>::State;
template struct DynamicFrameCompensator<double>::State;

}  // namespace tactbench::analysis
