#include "analysis/judgement/mpe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/loop.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/statistics/numbers/coverage.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

// All frames at one set-point on branches of one direction.
struct LevelErrors {
  double pressure_psi = 0.0;
  bool up = true;
  int frames = 0;
  std::vector<double> sum_psi;  // taxels: estimate - measured reference
};

// For each step of each sequence its LevelErrors.
using StepLevels = std::vector<std::vector<std::size_t>>;

StepLevels levels_of(const Dataset& dataset, std::vector<LevelErrors>& levels) {
  std::map<std::pair<long long, bool>, std::size_t> known;  // by millionths of a psi
  StepLevels of_steps;
  for (const SequenceData& data : dataset.sequences) {
    std::vector<double> commanded;
    for (const Sample& step : data.repeats.front().steps) commanded.push_back(step.setpoint_psi);
    std::vector<std::size_t>& own = of_steps.emplace_back(commanded.size(), 0);
    for (const Branch& branch : branches_along(commanded)) {
      // The turning point closes the branch before it.
      for (int i = branch.first == 0 ? 0 : branch.first + 1; i <= branch.last; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const auto [level, added] =
            known.try_emplace({std::llround(1e6 * commanded[at]), branch.ascending}, levels.size());
        if (added) levels.push_back({commanded[at], branch.ascending, 0, {}});
        own[at] = level->second;
        levels[level->second].frames += static_cast<int>(data.repeats.size());
      }
    }
  }
  for (LevelErrors& level : levels) level.sum_psi.assign(static_cast<std::size_t>(dataset.taxels()), kNan);
  return of_steps;
}

std::vector<LevelErrors> level_errors(const Dataset& measured, const SensorModel& measured_fit, int threads) {
  SensorModel fit = measured_fit;
  const Dataset dataset = as_modelled(measured, fit);
  fit.falling = false;
  std::vector<LevelErrors> levels;
  const StepLevels of_steps = levels_of(dataset, levels);
  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      double& sum = levels[of_steps[s][i]].sum_psi[taxel];
      sum = (std::isnan(sum) ? 0.0 : sum) + now.pressure_psi - dataset.sequences[s].repeats[r].steps[i].reference_psi;
    };
  });
  return levels;
}

bool counts_for(const Limits::Mpe& mpe, const LevelErrors& level) {
  return level.pressure_psi >= mpe.low_psi - kTypedLevelPsi && level.pressure_psi <= mpe.high_psi + kTypedLevelPsi;
}

// U of a reading; NaN where no budget of the branch knows the taxel.
double expanded_at(const Uncertainty& readings, double pressure_psi, bool up, std::size_t taxel) {
  double below = kNan, above = kNan, low = -std::numeric_limits<double>::infinity(), high = -low;
  for (const LevelUncertainty& level : readings.levels) {
    if (level.up != up || std::isnan(level.expanded_psi[taxel])) continue;
    if (level.pressure_psi <= pressure_psi + kSameLevelPsi && level.pressure_psi > low) {
      low = level.pressure_psi;
      below = level.expanded_psi[taxel];
    }
    if (level.pressure_psi >= pressure_psi - kSameLevelPsi && level.pressure_psi < high) {
      high = level.pressure_psi;
      above = level.expanded_psi[taxel];
    }
  }
  return std::fmax(below, above);
}

// Smallest value that at least `share` of the values are at most.
double quantile_over_taxels(std::vector<double> values, double share) {
  if (values.empty()) return kNan;
  std::ranges::sort(values);
  const double place = std::ceil(share * static_cast<double>(values.size()) - 1e-9);
  return values[static_cast<std::size_t>(std::max(1.0, place)) - 1];
}

}  // namespace

Scope scope_of(const Limits::Mpe& mpe) { return Scope::span(mpe.low_psi, mpe.high_psi, mpe.share); }

std::vector<MpeFigure> mpe_figures(const Dataset& judged, const SensorModel& fit, const Uncertainty* readings,
                                   std::span<const Limits::Mpe> limits, int threads) {
  std::vector<MpeFigure> figures;
  if (limits.empty()) return figures;
  check_same_sensor(judged, fit);
  const std::vector<LevelErrors> levels = level_errors(judged, fit, threads);
  for (const Limits::Mpe& mpe : limits) {
    MpeFigure figure{scope_of(mpe), kNan, kNan, 0};
    std::vector<double> errors, with_u;
    for (const std::size_t taxel : fit.fitted()) {
      double error = kNan, most = kNan;
      bool known = readings != nullptr;
      for (const LevelErrors& level : levels) {
        if (!counts_for(mpe, level)) continue;
        const double own = std::abs(level.sum_psi[taxel] / level.frames);
        error = std::fmax(error, own);
        if (!known) continue;
        const double expanded = expanded_at(*readings, level.pressure_psi, level.up, taxel);
        known = !std::isnan(expanded) && readings->reference.holds_at(level.pressure_psi);
        most = std::fmax(most, own + expanded);
      }
      if (!std::isnan(error)) errors.push_back(error);
      with_u.push_back(known ? most : std::numeric_limits<double>::infinity());
    }
    figure.levels = static_cast<int>(
        std::ranges::count_if(levels, [&](const LevelErrors& level) { return counts_for(mpe, level); }));
    figure.value_psi = quantile_over_taxels(std::move(errors), mpe.share);
    const double guarded = quantile_over_taxels(std::move(with_u), mpe.share);
    if (std::isfinite(guarded)) figure.expanded_psi = guarded - figure.value_psi;
    figures.push_back(std::move(figure));
  }
  return figures;
}

std::vector<Figure> judged_mpe(std::span<const MpeFigure> figures, const std::string& missing) {
  std::vector<Figure> all;
  for (const MpeFigure& figure : figures) {
    Figure& out = all.emplace_back(Figure{Criterion::kMpe, figure.scope, figure.value_psi, {}});
    out.u = {figure.expanded_psi, 0.5 * figure.expanded_psi, kInfiniteDof, 2.0, {}, {}};
    if (!std::isnan(figure.expanded_psi))
      out.u.basis =
          "U of one taxel's reading at its level and branch (section Uncertainty), added to |error| before the share "
          "of taxels is taken; the value is the |error| that this share of the taxels does not exceed";
    else
      out.u.missing = missing.empty() ? "no budget of a reading at the levels judged" : missing;
  }
  return all;
}

}  // namespace tactbench::analysis
