#include "analysis/identify/residuals.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "analysis/compensate/document.h"
#include "analysis/identify/compensators.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/models/interval.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kMostSamples = 20'000;  // of a taxel: longer recordings add nothing but time
constexpr std::size_t kChosen = 32;           // taxels at most whose models are fitted again
constexpr int kStarts = 2;                    // of GPI's search: enough to tell how far off it is
// What models without lag and creep do not know of holds and speeds that were not measured; chosen, as the limits of
// residual_by_level, on study seeds 2 to 5.
constexpr double kNoTimes = 1.25;

// ErrorSquares of a stream's errors over the shape.
struct ErrorSquares {
  double sum = 0.0, count = 0.0;
  [[nodiscard]] double mean() const { return count > 0.0 ? sum / count : 0.0; }
  void add(const ErrorSquares& other) {
    sum += other.sum;
    count += other.count;
  }
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

// Of all samples, and of those that `counts(h, i)`: sample i of history h.
template <class Counts>
std::pair<ErrorSquares, ErrorSquares> errors_of(const std::vector<const History*>& histories, const SensorModel& model,
                                                const ModelTaxel& taxel, const Counts& counts) {
  std::pair<ErrorSquares, ErrorSquares> errors;
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
        if (now.unknown || now.held) continue;
        const std::size_t at = interval_of((now.pressure_psi - low) / span * static_cast<double>(levels), levels);
        const double error = (now.pressure_psi - history.x[i]) / shape[stream->ascending() ? at : levels + at];
        errors.first.add({error * error, 1.0});
        if (counts(h, i)) errors.second.add({error * error, 1.0});
      }
    }
  } catch (const std::invalid_argument&) {  // an inverse without a value: nothing is known
    return {};
  } catch (const AnalysisError&) {
    return {};
  }
  return errors;
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
    const auto alike = [](const History& a, const History& b) {
      return std::ranges::equal(a.branches, b.branches, {}, &Branch::first, &Branch::first);
    };
    if (!taxels.empty() && !std::ranges::equal(own.fit, taxels.front().fit, alike)) continue;  // inputs of its own
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
  const bool run = histories.run != 0;
  const LeftOut held = leave_out(histories, sequences, model, threads);
  const auto part_of = [&](std::size_t h, std::size_t i) {
    return h < held.part.size() && i < held.part[h].size() ? held.part[h][i] : -1;
  };
  std::vector<std::pair<ErrorSquares, ErrorSquares>> fitted(model.taxels.size());
  for_each_index(fitted.size(), threads, [&](std::size_t t) {
    const ModelTaxel& taxel = model.taxels[t];
    if (taxel.fitted() && !taxel.ascending.x().empty())
      fitted[t] = errors_of(chosen(histories.taxels[t], run, sequences), model, taxel,
                            [&](std::size_t h, std::size_t i) { return part_of(h, i) >= 0; });
  });
  std::vector<ErrorSquares> left(held.places.size());
  for_each_index(left.size(), threads, [&](std::size_t k) {
    const auto own = chosen(histories.taxels[held.places[k]], run, sequences);
    if (own.size() != held.part.size()) return;
    for (std::size_t f = 0; f < held.models.size(); ++f)
      if (held.models[f].taxels[k].fitted())
        left[k].add(errors_of(own, held.models[f], held.models[f].taxels[k], [&](std::size_t h, std::size_t i) {
                      return part_of(h, i) == static_cast<int>(f);
                    }).second);
  });
  ErrorSquares inner, of_held, array;
  for (std::size_t k = 0; k < left.size(); ++k) {
    inner.add(fitted[held.places[k]].second);
    of_held.add(left[k]);
    array.add(fitted[held.places[k]].first);
  }
  for (std::size_t t = 0; t < fitted.size(); ++t) {
    const ErrorSquares& own = fitted[t].first;
    if (own.count == 0.0) continue;
    const double residual2 = of_held.count > 0.0 ? residual2_of_taxel(between_branches({of_held.mean(), inner.mean()}),
                                                                      own.mean(), array.mean())
                                                 : own.mean() + between_external_branches(model.taxels[t]);
    model.taxels[t].residual_psi = kNoTimes * std::sqrt(residual2);
  }
}

}  // namespace tactbench::analysis
