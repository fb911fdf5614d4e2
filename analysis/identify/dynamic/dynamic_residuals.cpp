#include "analysis/identify/dynamic/dynamic_residuals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "analysis/error.h"
#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/fit_run_creep.h"
#include "analysis/identify/residuals.h"
#include "analysis/models/interval.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr double kSmoothed = 0.1;  // of the range: standard deviation of the weights

// Squares of what a stream leaves, by interval of the estimate: rising, then falling.
struct Squares {
  std::vector<double> sum, count;
  explicit Squares(std::size_t intervals) : sum(2 * intervals, 0.0), count(2 * intervals, 0.0) {}
  void add(const Squares& other) {
    for (std::size_t k = 0; k < sum.size(); ++k) {
      sum[k] += other.sum[k];
      count[k] += other.count[k];
    }
  }
  [[nodiscard]] double samples() const { return std::reduce(count.begin(), count.end()); }
  [[nodiscard]] double mean() const { return std::reduce(sum.begin(), sum.end()) / samples(); }
};

// Of the taxels' Preisach models.
std::size_t intervals_of(const SensorModel& model) {
  const auto fitted = std::ranges::find_if(model.taxels, &ModelTaxel::fitted);
  return dynamic_cast<const PreisachModel&>(linearised_of(*fitted)->inner()).intervals();
}

double volts_of(const Repeat& repeat, std::size_t i, std::size_t taxel, const SensorModel& model, std::size_t width) {
  const double* const row = &repeat.volts[i * width];
  if (taxel < width) return row[taxel];
  double sum = 0.0, count = 0.0;  // the mean taxel
  for (std::size_t own = 0; own < width; ++own) {
    if (!model.taxels[own].fitted()) continue;
    sum += row[own];
    count += 1.0;
  }
  return sum / count;
}

// `taxel` of the model that is in use or of one like it, in the place `t` of `in_use`; of samples that `counts(s, i)`:
// sample i of sequence s.
template <class Counts>
Squares squares_of(const Dataset& data, const SensorModel& in_use, const ModelTaxel& taxel, std::size_t t,
                   const Counts& counts) {
  const auto width = static_cast<std::size_t>(data.taxels());
  const std::size_t n = intervals_of(in_use);
  const double low = in_use.pressure_psi.front(), span = in_use.pressure_psi.back() - low;
  Squares squares(n);
  const auto stream = compensator_of(in_use, taxel);
  stream_samples(
      data, *stream, [&](const Repeat& repeat, std::size_t i) { return volts_of(repeat, i, t, in_use, width); },
      [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        if (!counts(s, i)) return;
        const std::size_t at = interval_of((now.pressure_psi - low) / span * static_cast<double>(n), n);
        const std::size_t k = stream->ascending() ? at : n + at;
        squares.sum[k] += std::pow(now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi, 2);
        squares.count[k] += 1.0;
      });
  return squares;
}

std::vector<double> shape_of(const Squares& left) {
  const std::size_t n = left.sum.size() / 2;
  std::vector<double> shape;
  for (std::size_t k = 0; k < 2 * n; ++k) {
    double sum = 0.0, count = 0.0;
    for (std::size_t j = k / n * n; j < k / n * n + n; ++j) {
      const double off = (static_cast<double>(j) - static_cast<double>(k)) / (kSmoothed * static_cast<double>(n));
      const double weight = std::exp(-0.5 * off * off);
      sum += weight * left.sum[j];
      count += weight * left.count[j];
    }
    shape.push_back(count > 0.0 ? std::sqrt(0.5 + 0.5 * sum / count / left.mean()) : 1.0);
  }
  return shape;
}

}  // namespace

void find_dynamic_residuals(const Dataset& fitted, const Dataset& undone, const FitOptions& fit, SensorModel& model) {
  HistoriesOptions gathered;
  gathered.common = fit.common;
  gathered.dead_v = fit.dead_v;
  gathered.all_scores = false;
  gathered.threads = fit.threads;
  const LeftOut held = leave_out(histories_of(undone, gathered), {}, model, fit.threads);
  const Dataset data = as_modelled(fitted, model);
  const std::size_t n = intervals_of(model);
  std::vector<Squares> own(model.taxels.size(), Squares(n)), of_held(held.places.size(), Squares(n));
  for_each_index(own.size(), fit.threads, [&](std::size_t t) {
    if (model.taxels[t].fitted())
      own[t] = squares_of(data, model, model.taxels[t], t, [](std::size_t, std::size_t) { return true; });
  });
  std::vector<Squares> of_fitted = of_held;
  for_each_index(of_held.size(), fit.threads, [&](std::size_t k) {
    const ModelTaxel& in_use = model.taxels[held.places[k]];
    of_fitted[k] = squares_of(data, model, in_use, held.places[k],
                              [&](std::size_t s, std::size_t i) { return held.part[s][i] >= 0; });
    for (std::size_t f = 0; f < held.models.size(); ++f) {
      ModelTaxel other = held.models[f].taxels[k];
      if (!other.fitted()) continue;
      other.creep_scale = in_use.creep_scale;
      other.lag_share = in_use.lag_share;
      of_held[k].add(squares_of(data, model, other, held.places[k],
                                [&](std::size_t s, std::size_t i) { return held.part[s][i] == static_cast<int>(f); }));
    }
  });
  Squares left(n), inner(n), all(n);
  for (std::size_t k = 0; k < of_held.size(); ++k) {
    left.add(of_held[k]);
    inner.add(of_fitted[k]);
    all.add(own[held.places[k]]);
  }
  const bool told = left.samples() > 0.0;
  for (std::size_t t = 0; t < own.size(); ++t) {
    if (own[t].samples() == 0.0) continue;
    const double residual2 =
        told ? residual2_of_taxel(between_branches({left.mean(), inner.mean()}), own[t].mean(), all.mean())
             : own[t].mean() + between_external_branches(model.taxels[t]);
    model.taxels[t].residual_psi = std::sqrt(residual2);
  }
  model.dynamics->residual_shape = told && left.mean() > 0.0 ? shape_of(left) : std::vector<double>(2 * n, 1.0);
}

namespace {

void check_times(const SensorModel& model, const Histories& histories) {
  for (const TaxelHistories& taxel : histories.taxels)
    for (const History& history : taxel.score)
      if (history.time_s.size() != history.x.size())
        throw AnalysisError("TB-MODEL-DYNAMIC",
                            fmt::format("{} tells no times, and without them the dynamic model of {} cannot undo lag "
                                        "and creep",
                                        histories.source, model.source),
                            "give a run, or a table with a column time_s in seconds");
}

void undo(const Dynamics& d, const ModelTaxel& taxel, bool run, std::vector<History>& histories) {
  const HysteresisModel& film = *taxel.fit.model;
  const double x_low = film.x_low(), span = film.x_high() - x_low;
  const double zero = taxel.from_model(film.state()->output_at(x_low));
  DynamicsState state;
  double before = -1.0;
  for (History& history : histories) {
    if (!run) {
      state = {};
      before = -1.0;
    }
    for (std::size_t i = 0; i < history.x.size(); ++i) {
      const double time = history.time_s[i], pressure = history.x[i] - x_low;
      const DynamicsStep step = run ? next_step(d, state, {0.0, 0.0, time, history.held_s[i]}, before, span)
                                    : DynamicsStep(d, before < 0.0 ? 0.0 : std::max(time - before, 0.0));
      const double factor = creep_factor(d, state, step, pressure, taxel.creep_scale);
      history.y[i] = zero + (history.y[i] - zero) / factor;
      history.x[i] = x_low + arrived(taxel.lag_share, state, step, pressure);
      advance(d, state, step, pressure);
      before = time;
    }
  }
}

}  // namespace

Histories histories_without_dynamics(const SensorModel& model, Histories histories) {
  if (!in_time(*model.dynamics)) return histories;
  check_times(model, histories);
  for (TaxelHistories& taxel : histories.taxels) {
    const auto own = std::ranges::find(model.taxels, taxel.taxel, &ModelTaxel::taxel);
    if (own == model.taxels.end() || !own->fitted()) continue;
    undo(model.dynamics->shared, *own, histories.run != 0, taxel.score);
  }
  return histories;
}

}  // namespace tactbench::analysis
