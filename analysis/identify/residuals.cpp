#include "analysis/identify/residuals.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "analysis/compensate/document.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/linearised.h"
#include "analysis/models/pattern_curve.h"
#include "analysis/models/preisach.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kMostSamples = 20'000;  // of a taxel: longer recordings add nothing but time
constexpr std::size_t kChosen = 32;           // taxels at most whose models are fitted again
constexpr int kStarts = 2;                    // of GPI's search: enough to tell how far off it is
// What models without lag and creep do not know of holds and speeds that were not measured; chosen, as the limits of
// residual_by_level, on study seeds 2 to 5.
constexpr double kNoTimes = 1.25;

// Squares of what a stream leaves, by interval of the estimate: rising, then falling.
struct Squares {
  std::vector<double> sum, count;
  explicit Squares(std::size_t intervals) : sum(2 * intervals, 0.0), count(2 * intervals, 0.0) {}
  void add(std::size_t interval, bool rising, double error) {
    const std::size_t at = rising ? interval : sum.size() / 2 + interval;
    sum[at] += error * error;
    count[at] += 1.0;
  }
  void add(const Squares& other) {
    for (std::size_t k = 0; k < sum.size(); ++k) {
      sum[k] += other.sum[k];
      count[k] += other.count[k];
    }
  }
  [[nodiscard]] double samples() const { return std::reduce(count.begin(), count.end()); }
  [[nodiscard]] double mean() const { return std::reduce(sum.begin(), sum.end()) / samples(); }
};

// Histories as measured that belong to what was fitted; of a run the last repeat of each sequence.
std::vector<const History*> chosen(const TaxelHistories& taxel, bool run, const std::vector<std::string>& sequences) {
  std::vector<const History*> out;
  for (const History& history : taxel.score) {
    if (!sequences.empty() && std::ranges::find(sequences, history.name) == sequences.end()) continue;
    if (run && !out.empty() && out.back()->name == history.name)
      out.back() = &history;
    else
      out.push_back(&history);
  }
  return out;
}

// Whether the errors of a sample count: sample i of fitted history, or sequence, h.
using Counts = std::function<bool(std::size_t h, std::size_t i)>;
bool all_count(std::size_t, std::size_t) { return true; }

// The errors of a taxel's stream over the shape of its own model.
Squares squares_of(const std::vector<const History*>& histories, const SensorModel& model, const ModelTaxel& taxel,
                   const Counts& counts) {
  Squares squares(1);
  try {
    const std::vector<double> shape = residual_by_level(taxel.ascending, taxel.descending, 1.0);
    const double low = taxel.x0(), span = taxel.xu() - low;
    const std::size_t levels = shape.size() / 2;
    const auto stream = compensator_of(model, taxel);
    std::size_t left = kMostSamples;
    for (std::size_t h = 0; h < histories.size(); ++h) {
      const History& history = *histories[h];
      if (history.y.empty()) continue;
      stream->start(stream->at_rest(history.y.front()) ? Start::kAtRest : Start::kUnknown);
      for (std::size_t i = 0; i < history.x.size() && left > 0; ++i, --left) {
        const Compensated now = stream->step(history.y[i], 0.0);
        if (now.unknown || now.held || !counts(h, i)) continue;
        const std::size_t at = interval_of((now.pressure_psi - low) / span * static_cast<double>(levels), levels);
        const bool rising = stream->ascending();
        squares.add(0, rising, (now.pressure_psi - history.x[i]) / shape[rising ? at : levels + at]);
      }
    }
  } catch (const std::invalid_argument&) {  // an inverse without a value: nothing is known
    return Squares(1);
  } catch (const AnalysisError&) {
    return Squares(1);
  }
  return squares;
}

struct Residuals {
  std::vector<Squares> own;  // of each taxel on all samples
  Squares left, inner,
      all;  // of the chosen taxels: models that did not see a branch on it, those in use there, and all
  [[nodiscard]] bool known() const { return left.samples() > 0.0; }
};

// `squares(taxel, t, counts)`: of `taxel`, which is the model's one at place t or one like it.
template <class SquaresOf>
Residuals residuals_of(const SensorModel& model, const LeftOut& held, std::size_t intervals, int threads,
                       const SquaresOf& squares) {
  const Squares none(intervals);
  Residuals found{std::vector<Squares>(model.taxels.size(), none), none, none, none};
  std::vector<Squares> of_held(held.places.size(), none), in_use(held.places.size(), none);
  const auto part_of = [&](std::size_t h, std::size_t i) {
    return h < held.part.size() && i < held.part[h].size() ? held.part[h][i] : -1;
  };
  for_each_index(found.own.size(), threads, [&](std::size_t t) {
    if (model.taxels[t].fitted()) found.own[t] = squares(model.taxels[t], t, all_count);
  });
  for_each_index(of_held.size(), threads, [&](std::size_t k) {
    const std::size_t t = held.places[k];
    in_use[k] = squares(model.taxels[t], t, [&](std::size_t h, std::size_t i) { return part_of(h, i) >= 0; });
    for (std::size_t f = 0; f < held.models.size(); ++f) {
      ModelTaxel other = held.models[f].taxels[k];
      if (!other.fitted()) continue;
      other.creep_scale = model.taxels[t].creep_scale;
      other.lag_share = model.taxels[t].lag_share;
      of_held[k].add(
          squares(other, t, [&](std::size_t h, std::size_t i) { return part_of(h, i) == static_cast<int>(f); }));
    }
  });
  for (std::size_t k = 0; k < of_held.size(); ++k) {
    found.left.add(of_held[k]);
    found.inner.add(in_use[k]);
    found.all.add(found.own[held.places[k]]);
  }
  return found;
}

void set_residuals(const Residuals& found, double factor, SensorModel& model) {
  for (std::size_t t = 0; t < found.own.size(); ++t) {
    const Squares& own = found.own[t];
    if (own.samples() == 0.0) continue;
    const double residual2 = found.known()
                                 ? residual2_of_taxel(between_branches({found.left.mean(), found.inner.mean()}),
                                                      own.mean(), found.all.mean())
                                 : own.mean() + between_external_branches(model.taxels[t]);
    model.taxels[t].residual_psi = factor * std::sqrt(residual2);
  }
}

}  // namespace

LeftOut leave_out(Histories histories, const std::vector<std::string>& sequences, const SensorModel& model,
                  int threads) {
  LeftOut out;
  std::vector<std::size_t> usable;
  for (std::size_t t = 0; t < std::min(model.taxels.size(), histories.taxels.size()); ++t)
    if (model.taxels[t].fitted() && !histories.taxels[t].fit.empty() &&
        (model.taxels[t].taxel != kMeanTaxel || model.taxels.size() == 1))
      usable.push_back(t);
  std::vector<TaxelHistories> taxels;
  const std::size_t every = (usable.size() + kChosen - 1) / kChosen;
  for (std::size_t k = 0; k < usable.size(); k += every) {
    TaxelHistories& own = histories.taxels[usable[k]];
    own.fit = named(own.fit, sequences);
    const auto same_branches = [](const History& a, const History& b) {
      return std::ranges::equal(a.branches, b.branches, {}, &Branch::first, &Branch::first);
    };
    if (!taxels.empty() && !std::ranges::equal(own.fit, taxels.front().fit, same_branches))
      continue;  // inputs of its own
    out.places.push_back(usable[k]);
    taxels.push_back(std::move(own));
  }
  if (taxels.empty()) return out;
  // Any has the input's way; validity, which looks for one as measured, is of no account here.
  if (std::ranges::all_of(taxels, [](const auto& own) { return own.score.empty(); }))
    taxels.front().score = taxels.front().fit;
  histories.taxels = std::move(taxels);
  IdentifyOptions options = model.options;
  options.starts = std::min(options.starts, kStarts);
  const std::vector<TaxelHistories> whole = histories.taxels;
  for (const History& history : whole.front().fit) out.part.emplace_back(history.x.size(), -1);
  try {
    for (const Fold& fold : folds_of(fit_data_of(whole.front(), {}))) {
      for (std::size_t h = 0; h < fold.held.size(); ++h) {
        for (TaxelHistories& own : histories.taxels) own.fit[h].branches = fold.kept[h];
        for (const Branch& branch : fold.held[h])
          std::fill(out.part[h].begin() + branch.first + 1, out.part[h].begin() + branch.last + 1,
                    static_cast<int>(out.models.size()));
      }
      out.models.push_back(
          fit_models_without_residuals(model.dynamics ? "preisach" : model.model, histories, {}, options, threads));
    }
  } catch (const AnalysisError&) {  // what is left carries no model
    out.models.clear();
  }
  return out;
}

double between_branches(const InnerErrors& errors) { return std::max(0.5 * errors.held, errors.fitted); }

double residual2_of_taxel(double array, double own, double mean) {
  return mean > 0.0 ? array * 0.5 * (1.0 + own / mean) : array;
}

double between_external_branches(const ModelTaxel& taxel) {
  constexpr int kLevels = 20;
  const ExternalBranch up(taxel, true), down(taxel, false);
  double sum = 0.0;
  for (int k = 0; k < kLevels; ++k) {
    const double y = taxel.y0() + (taxel.yu() - taxel.y0()) * (k + 0.5) / kLevels, apart = up.input(y) - down.input(y);
    sum += apart * apart / (12.0 * kLevels);  // a rectangle
  }
  return sum;
}

void find_residuals(const Histories& histories, const std::vector<std::string>& sequences, int threads,
                    SensorModel& model) {
  if (model.taxels.size() > histories.taxels.size()) return;
  LeftOut held = leave_out(histories, sequences, model, threads);
  const auto chosen_of = [&](std::size_t t) { return chosen(histories.taxels[t], histories.run != 0, sequences); };
  if (!held.places.empty() && chosen_of(held.places.front()).size() != held.part.size()) held.models.clear();
  const Residuals found =
      residuals_of(model, held, 1, threads, [&](const ModelTaxel& taxel, std::size_t t, const Counts& counts) {
        return taxel.ascending.x().empty() ? Squares(1) : squares_of(chosen_of(t), model, taxel, counts);
      });
  set_residuals(found, kNoTimes, model);
}

// Of a model with lag and creep, in time: streams read the whole run.

namespace {

constexpr double kSmoothed = 0.1;  // of the range: standard deviation of the weights

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
  const auto width = static_cast<std::size_t>(data.taxels());
  const std::size_t n = intervals_of(model);
  const double low = model.pressure_psi.front(), span = model.pressure_psi.back() - low;
  const Residuals found =
      residuals_of(model, held, n, fit.threads, [&](const ModelTaxel& taxel, std::size_t t, const Counts& counts) {
        Squares squares(n);
        const auto stream = compensator_of(model, taxel);
        stream_samples(
            data, *stream, [&](const Repeat& repeat, std::size_t i) { return volts_of(repeat, i, t, model, width); },
            [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
              if (!counts(s, i)) return;
              squares.add(interval_of((now.pressure_psi - low) / span * static_cast<double>(n), n), stream->ascending(),
                          now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi);
            });
        return squares;
      });
  set_residuals(found, 1.0, model);
  model.dynamics->residual_shape =
      found.known() && found.left.mean() > 0.0 ? shape_of(found.left) : std::vector<double>(2 * n, 1.0);
}

}  // namespace tactbench::analysis
