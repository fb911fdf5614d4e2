#include "analysis/statistics/figures/sweep_estimates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"

namespace tactbench::analysis {
namespace {

constexpr double kSweepEndShare = 0.01;  // a sweep is full when its ends are this near to the models' range

// A full loading sweep: where its steps stand in the dataset.
struct FullSweep {
  std::size_t sequence, repeat, first, last;
};

std::vector<double> setpoints_of(const Dataset& dataset, const FullSweep& sweep) {
  const auto& steps = dataset.sequences[sweep.sequence].repeats[sweep.repeat].steps;
  std::vector<double> out;
  for (std::size_t i = sweep.first; i <= sweep.last; ++i) out.push_back(steps[i].setpoint_psi);
  return out;
}

std::vector<FullSweep> full_sweeps(const Dataset& dataset, double low, double high) {
  const double end = kSweepEndShare * (high - low);
  std::vector<FullSweep> sweeps;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      std::vector<double> x;
      for (const Sample& step : repeats[r].steps) x.push_back(step.setpoint_psi);
      for (const Branch& branch : branches_along(x)) {
        const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
        if (!branch.ascending || x[first] > low + end || x[last] < high - end) continue;
        const FullSweep sweep{s, r, first, last};
        if (sweeps.empty() || setpoints_of(dataset, sweep) == setpoints_of(dataset, sweeps.front()))
          sweeps.push_back(sweep);
      }
    }
  }
  return sweeps;
}

}  // namespace

double SweepEstimates::mean(std::size_t level, int taxel) const {
  double sum = 0.0;
  for (int sweep = 0; sweep < sweeps; ++sweep) sum += at(level, sweep, taxel);
  return sum / sweeps;
}

SweepEstimates sweep_estimates(const Dataset& dataset, const SensorModel& fit, int threads) {
  check_same_sensor(dataset, fit);
  if (fit.falling) {
    SensorModel rising = fit;
    rising.falling = false;
    return sweep_estimates(as_modelled(dataset, fit), rising, threads);
  }
  const std::vector<FullSweep> sweeps = full_sweeps(dataset, fit.pressure_psi.front(), fit.pressure_psi.back());
  if (sweeps.empty())
    throw AnalysisError("TB-ANALYSIS-NO-LOOP",
                        fmt::format("run {} has no full sweep from {}", dataset.run,
                                    both_units_span(fit.pressure_psi.front(), fit.pressure_psi.back())),
                        "compare runs of recipes with full loops: descending, ascending, production");
  const auto width = static_cast<std::size_t>(dataset.taxels());
  SweepEstimates out;
  out.pressure_psi = setpoints_of(dataset, sweeps.front());
  out.sweeps = static_cast<int>(sweeps.size());
  out.taxels = dataset.taxels();
  out.psi.assign(out.pressure_psi.size() * sweeps.size() * width, kNan);
  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel, next = std::size_t{0}](  // next: sweep
               std::size_t s, std::size_t r, std::size_t i, const Compensated& now) mutable {
      const auto is_over = [&](const FullSweep& sweep) {
        return std::tie(sweep.sequence, sweep.repeat, sweep.last) < std::tie(s, r, i);
      };
      while (next < sweeps.size() && is_over(sweeps[next])) ++next;
      if (next == sweeps.size()) return;
      const FullSweep& sweep = sweeps[next];
      if (sweep.sequence != s || sweep.repeat != r || i < sweep.first) return;
      const Sample& sample = dataset.sequences[s].repeats[r].steps[i];
      out.psi[((i - sweep.first) * sweeps.size() + next) * width + taxel] =
          now.pressure_psi + sample.setpoint_psi - sample.reference_psi;
    };
  });
  return out;
}

}  // namespace tactbench::analysis
