#include <algorithm>
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

void check_dynamics(const Dynamics& d) {
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    demand(std::isfinite(d.creep_s[j]) && d.creep_s[j] > 0.0, "a creep time is not positive");
    demand(std::isfinite(d.creep_share[j]) && d.creep_share[j] >= 0.0 && d.creep_share[j] < 0.3,
           "a creep share is not within 0 and 0.3");
  }
  demand(std::isfinite(d.creep_half) && d.creep_half > 0.0, "creep_half is not positive");
  demand(std::isfinite(d.lag_s) && d.lag_s > 0.0, "the lag's time is not positive");
}

void check_taxel(const DynamicTaxel& taxel, std::size_t intervals) {
  demand(taxel.everett.size() == Everett<double>::size(intervals), "its table does not have the size of the intervals");
  demand(std::ranges::all_of(taxel.everett, [](double value) { return std::isfinite(value); }),
         "a value of its table is not a finite number");
  const Everett<double> e{taxel.everett.data(), intervals};
  demand(e.top() > 0.0, "its output does not rise");
  for (std::size_t i = 1; i <= intervals; ++i)
    for (std::size_t j = 0; j < i; ++j)
      demand(e.at(i, j) >= e.at(i, j + 1) && e.at(i, j) >= e.at(i - 1, j) && e.at(j, j) == 0.0,
             "its table falls where it has to rise, or does not start at 0");
  demand(std::isfinite(taxel.divider.zero) && std::isfinite(taxel.divider.per_amplitude) &&
             taxel.divider.per_amplitude >= 0.0,
         "its divider is negative or not a finite number");
  demand(Divider{0.0, taxel.divider.per_amplitude}.output(e.top()) * taxel.divider.per_amplitude <= Divider::kMost,
         "its full output exceeds its divider's");
  demand(std::isfinite(taxel.noise_v) && taxel.noise_v >= 0.0, "its noise is negative or not a finite number");
  demand(std::isfinite(taxel.residual_scale) && taxel.residual_scale >= 0.0,
         "its residual_scale is negative or not finite");
  demand(taxel.creep_scale >= 0.0 && taxel.creep_scale <= 10.0, "its creep is not within 0 and 10");
  demand(taxel.lag_share >= 0.0 && taxel.lag_share <= 0.9, "its lag is not within 0 and 0.9");
}

}  // namespace

template <class Real>
DynamicFrameCompensator<Real>::State::State(const DynamicSetup& setup) {
  check_options(setup.options);
  check_dynamics(setup.dynamics);
  demand(std::isfinite(setup.x_low) && std::isfinite(setup.x_high) && setup.x_low < setup.x_high,
         "x_low is not below x_high");
  demand(setup.intervals >= 1 && setup.intervals <= 100, "intervals is not within 1 and 100");
  demand(!setup.taxels.empty(), "no taxels");
  demand(std::isfinite(setup.volts_per_count) && setup.volts_per_count > 0.0, "volts_per_count is not positive");
  demand(setup.longest_gap >= 0 && setup.tare_share >= 0.0, "longest_gap or tare_share is negative");
  demand(setup.observer.share >= 0.0 && setup.observer.share < 0.2 && setup.observer.forget >= 0.0 &&
             setup.observer.forget <= 1.0,
         "the observer's share is not within 0 and 0.2, or what it forgets not within 0 and 1");
  count = setup.taxels.size();
  intervals = setup.intervals;
  table_size = Everett<Real>::size(intervals);
  demand(setup.residual_psi.empty() || setup.residual_psi.size() == 2 * intervals,
         "residual_psi does not have two values an interval");
  for (const double residual : setup.residual_psi) {
    demand(std::isfinite(residual) && residual >= 0.0, "a residual is negative or not a finite number");
    residuals.push_back(static_cast<Real>(residual));
  }
  dynamics = setup.dynamics;
  demand(std::isfinite(setup.worked_s) && setup.worked_s >= 0.0, "worked_s is negative or not a finite number");
  work_unseen(dynamics, begin, setup.worked_s, setup.x_high - setup.x_low);
  options = setup.options;
  options.hold_in_noises = std::min(options.hold_in_noises, options.band_in_noises);
  observer = setup.observer;
  tare_share = setup.tare_share;
  longest_gap = setup.longest_gap;
  dispatch = best_dispatch();
  counts_per_volt = static_cast<Real>(1.0 / setup.volts_per_count);
  per_interval = static_cast<Real>((setup.x_high - setup.x_low) / static_cast<double>(intervals));
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
    try {
      check_taxel(taxel, intervals);
    } catch (const std::invalid_argument& fault) {
      throw std::invalid_argument("taxel " + std::to_string(t) + ": " + fault.what());
    }
    // Half a count of rounding is noise, too, and the least possible.
    const double noise = std::hypot(taxel.noise_v, setup.volts_per_count / std::sqrt(12.0));
    const double sign = taxel.falling ? -1.0 : 1.0;
    Taxel& own = taxels[t];
    own.usable = true;
    own.residual_scale = static_cast<Real>(taxel.residual_scale);
    own.plain_gain = static_cast<Real>(sign * setup.volts_per_count / noise);
    for (std::size_t k = 0; k < table_size; ++k)
      tables[t * table_size + k] = static_cast<Real>(taxel.everett[k] / noise);
    const double top = Divider{0.0, taxel.divider.per_amplitude}.output(taxel.everett[table_size - 1 - intervals]);
    own.top = static_cast<Real>(top / noise);
    b.zero[i] = static_cast<Real>(sign * taxel.divider.zero / setup.volts_per_count);
    b.divider[i] = static_cast<Real>(taxel.divider.per_amplitude * noise);
    b.highest[i] = own.top + shared.band;
    b.creep_scale[i] = static_cast<Real>(taxel.creep_scale);
    b.lag_share[i] = static_cast<Real>(taxel.lag_share);
    start(t, setup.start_unknown);
  }
}

template struct DynamicFrameCompensator<float>::State;
template struct DynamicFrameCompensator<double>::State;

}  // namespace tactbench::analysis
