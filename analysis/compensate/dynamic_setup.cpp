#include "analysis/compensate/dynamic_setup.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "analysis/compensate/everett.h"

namespace tactbench::analysis {
namespace {

void demand(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("dynamic compensator: " + what);
}

void check_dynamics(const Dynamics& d) {
  double sum = 0.0;
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    demand(std::isfinite(d.creep_s[j]) && d.creep_s[j] > 0.0, "a creep time is not positive");
    demand(std::isfinite(d.creep_share[j]) && d.creep_share[j] >= 0.0, "a creep share is negative or not finite");
    sum += d.creep_share[j];
  }
  demand(sum <= kMostCreep, "the creep shares exceed 0.9 together");
  demand(d.creep_half >= kLeastSpan && d.creep_half <= kMostPressure, "creep_half is not within 1e-9 and 1e9");
  demand(std::isfinite(d.lag_s) && d.lag_s > 0.0, "the lag's time is not positive");
}

void check_numbers(const DynamicTaxel& taxel, std::size_t intervals, const Dynamics& d) {
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
  demand(taxel.residual_scale >= 0.0 && taxel.residual_scale <= 1e6, "its residual_scale is not within 0 and 1e6");
  demand(taxel.creep_scale >= 0.0 && taxel.creep_scale <= kMostCreepScale, "its creep is not within 0 and 10");
  double creep = 0.0;
  for (const double share : d.creep_share) creep += taxel.creep_scale * share;
  demand(creep <= kMostCreep, "its creep exceeds 0.9 of its output");
  demand(taxel.lag_share >= 0.0 && taxel.lag_share <= 0.9, "its lag is not within 0 and 0.9");
}

}  // namespace

void check_setup(const DynamicSetup& setup) {
  check_options(setup.options);
  check_dynamics(setup.dynamics);
  demand(setup.x_low >= -kMostPressure && setup.x_high <= kMostPressure && setup.x_high - setup.x_low >= kLeastSpan,
         "x_low is not below x_high by 1e-9, or one of them beyond 1e9");
  demand(setup.intervals >= 1 && setup.intervals <= 100, "intervals is not within 1 and 100");
  demand(setup.observer.share >= 0.0 && setup.observer.share < 0.2 && setup.observer.forget >= 0.0 &&
             setup.observer.forget <= 1.0 && setup.observer.doubt >= 0.0 && setup.observer.doubt <= 1e9,
         "the observer's share is not within 0 and 0.2, what it forgets not within 0 and 1, or its doubt not within 0 "
         "and 1e9");
  demand(setup.residual_psi.empty() || setup.residual_psi.size() == 2 * setup.intervals,
         "residual_psi does not have two values an interval");
  for (const double residual : setup.residual_psi)
    demand(residual >= 0.0 && residual <= kMostPressure, "a residual is not within 0 and 1e9");
  demand(std::isfinite(setup.worked_s) && setup.worked_s >= 0.0, "worked_s is negative or not a finite number");
}

void check_taxel(const DynamicSetup& setup, const DynamicTaxel& taxel) {
  check_numbers(taxel, setup.intervals, setup.dynamics);
}

}  // namespace tactbench::analysis
