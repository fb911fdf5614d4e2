// Computes the figures of an evaluated run for which limits can be set, each with its U.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/judgement/figure.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

// Results of the models' run that several judged runs share, computed on first use.
struct ModelRunResults {
  std::optional<SweepErrors> sweeps;               // for rising outputs
  std::optional<std::vector<Evaluation>> repeats;  // each repeat evaluated separately
};

// All criteria except kMpe (mpe.h); kMismatch at every level in both directions. `evaluation` and `reference` belong to
// `judged`. U by criterion:
//   kMeanError, kWorstTaxelError   a common error of the reference moves them by at most itself (triangle inequality):
//                                  c = 1, not known without a certificate. Scatter: of a taxel from repeat to repeat,
//                                  pooled over the taxels, / sqrt(repeats)
//   kDistanceOfMean                the reference's error cancels in differences at one level. Scatter: of the array's
//                                  mean from full sweep to full sweep, pooled over the levels
//   kMismatch                      likewise; scatter of the figure from full sweep to full sweep
//   kUnfitTaxels                   a count by rule: U = 0
// Pooling (moments.h) states its own degrees of freedom (JCGM 100, H.3.6). The scatter is that of `judged`, or of
// `models` (the run from which they were made) if `judged` has only one repeat or one full sweep. Throws as evaluate().
std::vector<Figure> measured_figures(const Dataset& judged, const Dataset& models, const SensorModel& fit,
                                     const Evaluation& evaluation, const ReferenceUncertainty& reference,
                                     int threads = 0, ModelRunResults* shared = nullptr);

// Scatter of a judged figure from full sweep to full sweep. Used only by measured_figures.cpp.

// Scatter of one criterion's figure, as a standard uncertainty of the judged figure.
struct FigureScatter {
  double u = 0.0, dof = 0.0;
  std::string words;  // empty: not known
  [[nodiscard]] bool known() const { return !words.empty(); }
};

inline FigureScatter quotient(double s, double dof, std::size_t judged, std::string words) {
  if (judged > 1) words += fmt::format(", divided by √{}", judged);
  return {s / std::sqrt(static_cast<double>(std::max<std::size_t>(1, judged))), dof, std::move(words)};
}

// The full sweeps are the sample, because a repeat may contain several. From the judged run, or from the models' run if
// the judged one has fewer than two sweeps per direction.
class SweepScatter {
 public:
  // `of_models`: results of the models' run, filled in when needed.
  SweepScatter(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads,
               std::optional<SweepErrors>& of_models)
      : fitted_(fit), range_psi_(fit.pressure_psi.back()) {
    SensorModel rising = fit;
    rising.falling = false;
    judged_ = sweep_errors(as_modelled(judged, fit), rising, threads);
    const bool own = most(judged_, true) >= 2 && most(judged_, false) >= 2;
    if (!own && !of_models) of_models = sweep_errors(as_modelled(models, fit), rising, threads);
    sweeps_ = own ? judged_ : *of_models;
    run_ = own ? "the run judged" : "the run of the models";
  }

  // Scatter of the distance between loading and unloading of the array's mean, pooled over the levels; share of full
  // pressure.
  [[nodiscard]] FigureScatter distance() const {
    const auto mean = [this](const std::vector<double>& errors) { return mean_of(errors) / range_psi_; };
    const PooledScatter up = pooled_scatter(by_sweep(true, mean)), down = pooled_scatter(by_sweep(false, mean));
    const std::size_t judged_up = most(judged_, true), judged_down = most(judged_, false);
    if (!up.known() || !down.known() || judged_up == 0 || judged_down == 0) return {};
    const std::vector<VarianceShare> shares = {{up.s / std::sqrt(static_cast<double>(judged_up)), up.dof},
                                               {down.s / std::sqrt(static_cast<double>(judged_down)), down.dof}};
    const double dof = effective_dof(shares);
    return {combined_uncertainty(shares), dof,
            fmt::format("scatter of the mean of all taxels over {} loading and {} unloading full sweeps of {}, pooled "
                        "over the levels ({:.1f} degrees of freedom); the run judged has {} and {}",
                        up.rows, down.rows, run_, dof, judged_up, judged_down)};
  }

  // Scatter of the standard deviation over the taxels at one level; share of full pressure. At a level that not every
  // sweep passes, such as a turning point, the pooled scatter of the other levels.
  [[nodiscard]] FigureScatter mismatch(double pressure_psi, bool up) const {
    const LevelReadings* const level = level_of(sweeps_, pressure_psi, up);
    const std::size_t sweeps = most(sweeps_, up), judged = most(judged_, up);
    if (level == nullptr || sweeps < 2 || judged == 0) return {};
    if (level->readings < sweeps) {
      const PooledScatter pooled =
          pooled_scatter(by_sweep(up, [&](const std::vector<double>& e) { return spread(e); }));
      if (!pooled.known()) return {};
      return quotient(pooled.s, pooled.dof, judged,
                      fmt::format("scatter of the figure over {} full sweeps of {}, pooled over their common levels",
                                  pooled.rows, run_));
    }
    std::vector<double> spreads;
    for (std::size_t sweep = 0; sweep < sweeps; ++sweep)
      spreads.push_back(spread(fitted_.row(level->error_psi, sweep)));
    return quotient(sample_deviation(spreads), static_cast<double>(sweeps - 1), judged,
                    fmt::format("scatter of the figure over {} full sweeps of {}", sweeps, run_));
  }

 private:
  static std::size_t most(const SweepErrors& errors, bool up) {
    std::size_t sweeps = 0;
    for (const LevelReadings& level : errors.levels)
      if (level.up == up) sweeps = std::max(sweeps, level.readings);
    return sweeps;
  }
  static const LevelReadings* level_of(const SweepErrors& errors, double pressure_psi, bool up) {
    const auto found = std::ranges::find_if(errors.levels, [&](const LevelReadings& level) {
      return level.up == up && same_level(level.pressure_psi, pressure_psi);
    });
    return found == errors.levels.end() ? nullptr : &*found;
  }
  [[nodiscard]] double spread(const std::vector<double>& errors) const {
    return errors.size() < 2 ? 0.0 : sample_deviation(errors) / range_psi_;
  }
  // Sweeps x levels: `figure` computed from the taxels' errors; only levels that every sweep passes.
  template <class OfErrors>
  [[nodiscard]] std::vector<std::vector<double>> by_sweep(bool up, const OfErrors& figure) const {
    std::vector<std::vector<double>> rows(most(sweeps_, up));
    for (const LevelReadings& level : sweeps_.levels)
      for (std::size_t sweep = 0; sweep < rows.size() && level.up == up && level.readings == rows.size(); ++sweep)
        rows[sweep].push_back(figure(fitted_.row(level.error_psi, sweep)));
    return rows;
  }

  Fitted fitted_;
  double range_psi_;
  SweepErrors judged_, sweeps_;
  std::string run_;
};

}  // namespace tactbench::analysis
