#include "analysis/judgement/mpe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
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

// The conditions derived from the judged run for which U is valid.
std::vector<const ConditionUncertainty*> valid_for(std::int64_t run, const Uncertainty* readings) {
  std::vector<const ConditionUncertainty*> valid;
  if (readings == nullptr) return valid;
  for (const ConditionUncertainty& each : readings->conditions)
    if (each.valid() && std::ranges::find(each.runs, run) != each.runs.end()) valid.push_back(&each);
  return valid;
}

std::string why_not_known(std::int64_t run, const Uncertainty* readings) {
  if (readings != nullptr)
    for (const ConditionUncertainty& each : readings->conditions)
      if (std::ranges::find(each.runs, run) != each.runs.end())
        return fmt::format("U of a reading is not valid for {}: {}", each.name, each.not_valid);
  return fmt::format("run {} has no kind of history from which U of a reading follows", run);
}

// The largest |known error| + U over the kinds; NaN if none covers the level.
double most_at(std::span<const ConditionUncertainty* const> kinds, const LevelErrors& level, std::size_t taxel) {
  double most = kNan;
  for (const ConditionUncertainty* kind : kinds) {
    const auto [known, expanded] = reading_uncertainty(*kind, taxel, level.pressure_psi, level.up);
    most = std::fmax(most, std::abs(known) + expanded);
  }
  return most;
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
  const std::vector<const ConditionUncertainty*> kinds = valid_for(judged.run, readings);
  for (const Limits::Mpe& mpe : limits) {
    MpeFigure figure{scope_of(mpe), kNan, kNan, 0, {}, {}, {}};
    std::vector<double> errors, with_u;
    for (const std::size_t taxel : fit.fitted()) {
      double error = kNan, most = kNan;
      bool known = !kinds.empty();
      for (const LevelErrors& level : levels) {
        if (!counts_for(mpe, level)) continue;
        const double own = std::abs(level.sum_psi[taxel] / level.frames), limit = most_at(kinds, level, taxel);
        error = std::fmax(error, own);
        known = known && !std::isnan(limit);
        most = std::fmax(most, std::fmax(own, limit));
      }
      if (!std::isnan(error)) errors.push_back(error);
      with_u.push_back(known ? most : std::numeric_limits<double>::infinity());
    }
    figure.levels = static_cast<int>(
        std::ranges::count_if(levels, [&](const LevelErrors& level) { return counts_for(mpe, level); }));
    figure.value_psi = quantile_over_taxels(std::move(errors), mpe.share);
    const double guarded = quantile_over_taxels(std::move(with_u), mpe.share);
    for (const ConditionUncertainty* kind : kinds) {
      figure.kinds += (figure.kinds.empty() ? "" : "; ") + kind->name;
      figure.counted.push_back(kind->condition);
    }
    if (std::isfinite(guarded))
      figure.expanded_psi = guarded - figure.value_psi;
    else
      figure.not_known =
          kinds.empty() ? why_not_known(judged.run, readings) : "no valid kind of history covers a level of the span";
    figures.push_back(std::move(figure));
  }
  return figures;
}

std::vector<Figure> judged_mpe(std::span<const MpeFigure> figures) {
  std::vector<Figure> all;
  for (const MpeFigure& figure : figures) {
    Figure& out = all.emplace_back(Figure{Criterion::kMpe, figure.scope, figure.value_psi, {}});
    out.u = {figure.expanded_psi, 0.5 * figure.expanded_psi, kInfiniteDof, 2.0, {}, figure.not_known, figure.counted};
    if (!std::isnan(figure.expanded_psi))
      out.u.basis = fmt::format(
          "known |error| + U of one taxel's reading at its level and direction, the largest over {}, computed before "
          "the share of taxels; the value is the mean |error| that this share of the taxels does not exceed",
          figure.kinds);
  }
  return all;
}

}  // namespace tactbench::analysis
