#include "analysis/identify/residuals.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <stdexcept>

#include "analysis/compensate/document.h"
#include "analysis/identify/compensators.h"
#include "analysis/models/interval.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kMostSamples = 20'000;  // of a taxel: longer recordings add nothing but time
// The second part, of paths that were not fitted.
constexpr std::size_t kOpinions = 32;        // taxels at most, evenly chosen
constexpr int kOpinionCells = 15;            // intervals of their Preisach models
constexpr int kTurns = 60, kPathSteps = 30;  // of the random path, and of the whole range
// What a stream leaves of paths that were not fitted over what it leaves of those that were, as of the dynamic model.
// This and the limit of the shape were chosen on sensor seed 1 of both specimens.
constexpr double kOtherPaths = 2.0;

// Squares of a stream's errors over the shape.
struct Squares {
  double sum = 0.0, count = 0.0;
  [[nodiscard]] double mean() const { return count > 0.0 ? sum / count : 0.0; }
};

class ErrorsOf {
 public:
  explicit ErrorsOf(const SensorModel& model, const ModelTaxel& taxel)
      : shape_(residual_by_level(taxel.ascending, taxel.descending, 1.0)),
        low_(taxel.x0()),
        span_(taxel.xu() - low_),
        stream_(compensator_of(model, taxel)) {}
  void start(double output) { stream_->start(stream_->at_rest(output) ? Start::kAtRest : Start::kUnknown); }
  void step(double output, double input) {
    const Compensated now = stream_->step(output, 0.0);
    if (now.unknown || now.held) return;
    const std::size_t levels = shape_.size() / 2;
    const std::size_t at = interval_of((now.pressure_psi - low_) / span_ * static_cast<double>(levels), levels);
    const double error = (now.pressure_psi - input) / shape_[stream_->ascending() ? at : levels + at];
    squares_.sum += error * error;
    squares_.count += 1.0;
  }
  [[nodiscard]] const Squares& squares() const { return squares_; }

 private:
  std::vector<double> shape_;
  double low_, span_;
  std::unique_ptr<Compensator> stream_;
  Squares squares_;
};

// Histories as measured that belong to what was fitted; of a run the last repeat of each sequence.
std::vector<const History*> chosen(const Histories& histories, std::size_t taxel,
                                   const std::vector<std::string>& sequences) {
  std::vector<const History*> out;
  for (const History& history : histories.taxels[taxel].score) {
    if (!sequences.empty() && std::ranges::find(sequences, history.name) == sequences.end()) continue;
    if (histories.run != 0 && !out.empty() && out.back()->name == history.name)
      out.back() = &history;
    else
      out.push_back(&history);
  }
  return out;
}

Squares of_fitted(const Histories& histories, const std::vector<std::string>& sequences, const SensorModel& model,
                  std::size_t t) {
  ErrorsOf errors(model, model.taxels[t]);
  std::size_t left = kMostSamples;
  for (const History* const history : chosen(histories, t, sequences)) {
    if (history->y.empty()) continue;
    errors.start(history->y.front());
    for (std::size_t i = 0; i < history->x.size() && left > 0; ++i, --left) errors.step(history->y[i], history->x[i]);
  }
  return errors.squares();
}

// Inputs that go to and fro between random levels, in steps; always the same ones.
std::vector<double> wandering(double low, double high) {
  std::mt19937 random(17);
  std::vector<double> path{low};
  int at = 0, direction = 1;
  for (int turn = 0; turn < kTurns; ++turn, direction = -direction) {
    const int room = direction > 0 ? kPathSteps - at : at;
    if (room == 0) continue;
    const int steps = 1 + static_cast<int>(random() % static_cast<unsigned>(room));
    for (int i = 0; i < steps; ++i) path.push_back(low + (high - low) / kPathSteps * (at += direction));
  }
  return path;
}

// Over random reversals of another model of the same data; nothing where that cannot be fitted.
Squares of_other_paths(const Histories& histories, const std::vector<std::string>& sequences, const SensorModel& model,
                       std::size_t t) {
  const ModelTaxel& taxel = model.taxels[t];
  IdentifyOptions options;
  options.cells = kOpinionCells;
  const ModelFit other = identify_preisach(fit_data_of(histories.taxels[t], sequences), options);
  const auto film = other.model->state();
  ErrorsOf errors(model, taxel);
  for (const double x : wandering(taxel.x0(), taxel.xu())) {
    film->go(x);
    errors.step(film->output_at(x), x);
  }
  return errors.squares();
}

// Where an inverse has no value, or data carry no Preisach model, nothing is known.
template <class Action>
Squares or_none(const Action& action) {
  try {
    return action();
  } catch (const std::invalid_argument&) {
    return {};
  } catch (const AnalysisError&) {
    return {};
  }
}

}  // namespace

void find_residuals(const Histories& histories, const std::vector<std::string>& sequences, int threads,
                    SensorModel& model) {
  if (model.taxels.size() > histories.taxels.size()) return;
  std::vector<Squares> fitted(model.taxels.size());
  for_each_index(fitted.size(), threads, [&](std::size_t t) {
    const ModelTaxel& taxel = model.taxels[t];
    if (taxel.fitted() && !taxel.ascending.x().empty() && !histories.taxels[t].score.empty())
      fitted[t] = or_none([&] { return of_fitted(histories, sequences, model, t); });
  });
  double more = kOtherPaths * kOtherPaths;
  if (model.model != "preisach") {
    std::vector<std::size_t> usable, asked;
    for (std::size_t t = 0; t < fitted.size(); ++t)
      if (fitted[t].mean() > 0.0 && (model.taxels[t].taxel != kMeanTaxel || fitted.size() == 1)) usable.push_back(t);
    const std::size_t every = (usable.size() + kOpinions - 1) / kOpinions;
    for (std::size_t k = 0; k < usable.size(); k += every) asked.push_back(usable[k]);
    std::vector<Squares> others(asked.size());
    for_each_index(asked.size(), threads, [&](std::size_t k) {
      others[k] = or_none([&] { return of_other_paths(histories, sequences, model, asked[k]); });
    });
    double of_fits = 0.0, of_others = 0.0;
    for (std::size_t k = 0; k < asked.size(); ++k) {
      if (others[k].count == 0.0) continue;
      of_fits += fitted[asked[k]].mean();
      of_others += others[k].mean();
    }
    if (of_fits > 0.0) more += of_others / of_fits;
  }
  for (std::size_t t = 0; t < fitted.size(); ++t) model.taxels[t].residual_psi = std::sqrt(more * fitted[t].mean());
}

}  // namespace tactbench::analysis
