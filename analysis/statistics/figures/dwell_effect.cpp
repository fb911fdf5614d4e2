#include "analysis/statistics/figures/dwell_effect.h"

#include <algorithm>
#include <cmath>

#include "analysis/loop.h"
#include "analysis/statistics/figures/creep_effect.h"
#include "analysis/statistics/figures/history_errors.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/streams.h"

namespace tactbench::analysis {
namespace {

constexpr double kOtherPace = 2.0;  // dwell times that differ by this factor are two

double median_dwell_of(const Repeat& repeat) {
  std::vector<double> held;
  for (const Sample& sample : repeat.steps)
    if (sample.setpoint_psi > kHeldAbovePsi && sample.held_s > 0.0) held.push_back(sample.held_s);
  return median_of(std::move(held));
}

// Change of each step against the base repeat, squared, into the windows that it lies in.
void add_changes(const std::vector<std::vector<double>>& errors, const SequenceData& loop, std::size_t base,
                 const SensorModel& fit, DwellEffect& effect) {
  const std::size_t width = fit.array().size(), levels = fit.pressure_psi.size();
  const std::vector<StepKind> kinds = step_kinds(loop, fit.pressure_psi.front(), fit.pressure_psi.back());
  effect.square_psi.assign(2 * levels * width, kNan);
  for (std::size_t r = 0; r < errors.size(); ++r) {
    if (r == base) continue;
    for (std::size_t at = 0; at < 2 * levels; ++at) {
      const double level = fit.pressure_psi[at % levels];
      std::vector<std::size_t> steps;
      for (std::size_t i = 0; i < kinds.size(); ++i)
        if (kinds[i].up == (at < levels) &&
            std::abs(loop.repeats[base].steps[i].setpoint_psi - level) <= kHistoryWindowPsi + kSameLevelPsi)
          steps.push_back(i);
      for (std::size_t taxel = 0; taxel < width && !steps.empty(); ++taxel) {
        double squares = 0.0;
        for (const std::size_t i : steps)
          squares += std::pow(errors[r][i * width + taxel] - errors[base][i * width + taxel], 2);
        double& largest = effect.square_psi[at * width + taxel];
        largest = std::fmax(largest, squares / static_cast<double>(steps.size()));
      }
    }
  }
}

}  // namespace

double median_dwell_s(const Dataset& dataset) {
  std::vector<double> medians;
  for (const SequenceData& sequence : dataset.sequences)
    for (const Repeat& repeat : sequence.repeats) medians.push_back(median_dwell_of(repeat));
  return median_of(std::move(medians));
}

DwellEffect dwell_effect_of(const Dataset& calibration, std::span<const Dataset* const> runs, const SensorModel& fit,
                            int threads) {
  DwellEffect effect;
  const double usual = median_dwell_s(calibration);
  for (const Dataset* run : runs) {
    for (std::size_t s = 0; s < run->sequences.size(); ++s) {
      const SequenceData& loop = run->sequences[s];
      std::vector<double> dwell;
      for (const Repeat& repeat : loop.repeats) dwell.push_back(median_dwell_of(repeat));
      if (dwell.size() < 2 || std::ranges::any_of(dwell, [](double at) { return !(at > 0.0); }) || !(usual > 0.0))
        continue;
      const auto [low, high] = std::ranges::minmax(dwell);
      if (high < kOtherPace * low) continue;
      const auto off = [&](double at) { return std::abs(std::log(at / usual)); };
      const auto base = static_cast<std::size_t>(std::ranges::min_element(dwell, {}, off) - dwell.begin());
      const std::size_t width = fit.array().size();
      std::vector<std::vector<double>> errors(dwell.size(),
                                              std::vector<double>(loop.repeats[0].steps.size() * width, kNan));
      compensate_in_order(*run, fit, threads, [&](std::size_t taxel) {
        return [&, taxel](std::size_t at, std::size_t r, std::size_t i, const Compensated& now) {
          if (at == s) errors[r][i * width + taxel] = now.pressure_psi - loop.repeats[r].steps[i].reference_psi;
        };
      });
      effect.run = run->run;
      effect.low_s = low;
      effect.high_s = high;
      effect.base_s = dwell[base];
      add_changes(errors, loop, base, fit, effect);
      effect.not_assessed.clear();
      return effect;
    }
  }
  return effect;
}

}  // namespace tactbench::analysis
