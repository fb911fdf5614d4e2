// From histories to the model of a sensor: the one way that every model takes.
#include "analysis/identify/fit_models.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/linearise.h"
#include "analysis/identify/residuals.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/all_models.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kOtherData = "fit sequences that hold what is missing, or another model";

// Taxels of a run share their inputs; those of a table need not.
bool has_same_inputs(const FitData& a, const FitData& b) {
  return std::ranges::equal(a.histories, b.histories, {}, &History::x, &History::x) &&
         std::ranges::equal(a.ascending.x(), b.ascending.x());
}

AnalysisError cannot_be_fitted(const Histories& histories, const std::string& model, const std::string& why) {
  return {"TB-ANALYSIS-MODEL", fmt::format("{}: {} cannot be fitted: {}", histories.source, model, why), kOtherData};
}

class SensorFitter {
 public:
  SensorFitter(const std::string& model, const Histories& histories, const std::vector<std::string>& sequences,
               const IdentifyOptions& options)
      : model_(model), histories_(histories), sequences_(sequences), options_(options), like_(first_that_rises()) {
    try {
      shared_ = prepare(model_, like_, options_);
    } catch (const std::invalid_argument& error) {
      throw cannot_be_fitted(histories_, model_, error.what());
    }
  }

  [[nodiscard]] const FitData& like() const { return like_; }

  [[nodiscard]] ModelTaxel fit(const TaxelHistories& own) const {
    ModelTaxel taxel;
    taxel.taxel = own.taxel;
    taxel.noise = own.noise;
    taxel.status = own.status;
    if (!own.usable()) return taxel;
    taxel.status = TaxelStatus::kUnfit;
    try {
      fit_data(fit_data_of(own, sequences_), taxel);
    } catch (const AnalysisError& error) {
      if (error.id() != "TB-ANALYSIS-FALLING") taxel.reason = error.what();  // else it moves, but not with the input
    } catch (const std::invalid_argument& error) {
      taxel.reason = error.what();
    }
    if (!own.wild.empty()) {
      taxel.status = TaxelStatus::kUnfit;
      taxel.reason = own.wild;
    }
    return taxel;
  }

  // Of the fitted taxels; where there are none, of those that have a model.
  void add_mean(SensorModel& fit) const {
    std::vector<std::size_t> chosen = fit.fitted();
    for (std::size_t i = 0; chosen.empty() && i < fit.taxels.size(); ++i)
      if (fit.taxels[i].fit.model != nullptr) chosen.push_back(i);
    if (chosen.empty()) return;
    const std::optional<FitData> data = mean_fit_data(histories_, chosen, sequences_);
    if (!data) return;
    ModelTaxel mean;
    mean.taxel = kMeanTaxel;
    for (const std::size_t i : chosen) mean.noise += fit.taxels[i].noise * fit.taxels[i].noise;
    mean.noise = std::sqrt(mean.noise) / static_cast<double>(chosen.size());
    fit_data(*data, mean);
    fit.taxels.push_back(std::move(mean));
  }

 private:
  [[nodiscard]] FitData first_that_rises() const {
    std::optional<AnalysisError> last;
    for (const TaxelHistories& taxel : histories_.taxels) {
      if (!taxel.usable()) continue;
      try {
        return fit_data_of(taxel, sequences_);
      } catch (const AnalysisError& error) {
        if (error.id() != "TB-ANALYSIS-FALLING") throw;
        last = error;
      }
    }
    throw *last;
  }

  void fit_data(const FitData& data, ModelTaxel& taxel) const {
    taxel.loop_low = data.ascending.y().front();
    if (data.ascending.y().back() - taxel.loop_low < histories_.min_span) return;  // moves, but not with the input
    try {
      taxel.fit = has_same_inputs(data, like_) ? shared_->fit(data) : identify(model_, data, options_);
      set_loop(taxel, data.ascending.x(), data.ascending.y(), data.descending.y());
    } catch (const std::invalid_argument& error) {
      taxel.fit = {};
      taxel.reason = error.what();
      return;
    }
    if (taxel.fit.mean_error <= kUnfitShare * taxel.full_scale()) taxel.status = TaxelStatus::kFitted;
  }

  const std::string& model_;
  const Histories& histories_;
  const std::vector<std::string>& sequences_;
  const IdentifyOptions& options_;
  FitData like_;
  std::unique_ptr<Identifier> shared_;
};

SensorModel described(const std::string& model, const Histories& histories, const std::vector<std::string>& sequences,
                      const IdentifyOptions& options) {
  SensorModel fit;
  fit.model = model;
  fit.options = options;
  fit.run = histories.run;
  fit.source = histories.source;
  fit.origin = histories.origin;
  fit.content_sha256 = histories.content_sha256;
  fit.sequences = sequences.empty() ? histories.sequences : sequences;
  fit.all_sequences = std::ranges::is_permutation(fit.sequences, histories.sequences);
  fit.sensor_serial = histories.sensor_serial;
  fit.scanner_serial = histories.scanner_serial;
  fit.input_unit = histories.input_unit;
  fit.output_unit = histories.output_unit;
  fit.rows = histories.rows;
  fit.columns = histories.columns;
  fit.scans = histories.scans;
  fit.falling = histories.falling;
  return fit;
}

}  // namespace

SensorModel fit_models_without_residuals(const std::string& model, const Histories& histories,
                                         const std::vector<std::string>& sequences, const IdentifyOptions& options,
                                         int threads) {
  SensorModel fit = described(model, histories, sequences, options);
  const SensorFitter fitter(model, histories, sequences, options);
  const auto scored = std::ranges::find_if(histories.taxels, [](const auto& t) { return !t.score.empty(); });
  fit.validity = validity_of(named(scored->score, sequences), histories.temperatures_c);
  const auto inputs = fitter.like().ascending.x();
  fit.pressure_psi.assign(inputs.begin(), inputs.end());
  const bool with_mean = histories.taxels.size() > 1 && histories.taxels.back().taxel == kMeanTaxel;
  fit.taxels.resize(histories.taxels.size() - (with_mean ? 1 : 0));
  for_each_index(fit.taxels.size(), threads, [&](std::size_t i) { fit.taxels[i] = fitter.fit(histories.taxels[i]); });
  if (with_mean) fitter.add_mean(fit);
  if (std::ranges::any_of(fit.taxels, [](const ModelTaxel& t) { return t.fit.model != nullptr; })) return fit;
  const auto first = std::ranges::find_if(histories.taxels, [](const auto& t) { return t.usable(); });
  throw cannot_be_fitted(histories, model,
                         fit.taxels[static_cast<std::size_t>(first - histories.taxels.begin())].why());
}

SensorModel fit_models(const std::string& model, const Histories& histories, const std::vector<std::string>& sequences,
                       const IdentifyOptions& options, int threads) {
  SensorModel fit = fit_models_without_residuals(model, histories, sequences, options, threads);
  if (!options.by_input) find_residuals(histories, sequences, threads, fit);  // of the dynamic model it finds its own
  return fit;
}

SensorModel fit_array(const Dataset& dataset, const FitOptions& options) {
  HistoriesOptions gathered;
  gathered.common = options.common;
  gathered.dead_v = options.dead_v;
  gathered.threads = options.threads;
  gathered.all_scores = options.mean_alone || !options.identify.by_input;
  Histories histories = histories_of(dataset, gathered);
  if (options.mean_alone) histories = mean_taxel_of(std::move(histories));
  SensorModel fit = fit_models(options.model, histories, options.sequences, options.identify, options.threads);
  if (options.mean_alone) return fit;
  const std::vector<std::size_t> fitted = fit.fitted();
  if (fitted.empty())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("run {}: no taxel could be fitted", fit.run),
                        "check the frames: dead, stuck and saturated taxels are left out");
  fit.repeats = repeat_drifts(dataset, fitted, options.common);
  return fit;
}

namespace {

template <class... Models>
constexpr auto rows_of(ModelList<Models...> /*of*/) {
  return std::array{ModelKind{Models::kName, Models::kOfLoop, Models::kFitShare, Models::prepare, Models::known}...};
}

constexpr std::array kModelKinds = rows_of(AllModels());

}  // namespace

std::span<const ModelKind> model_kinds() { return kModelKinds; }

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const ModelKind& kind : kModelKinds) names.emplace_back(kind.name);
  return names;
}

std::unique_ptr<Identifier> prepare(const std::string& name, const FitData& like, const IdentifyOptions& options) {
  const auto* const kind = std::ranges::find(kModelKinds, name, &ModelKind::name);
  if (kind == kModelKinds.end()) throw std::invalid_argument("there is no model named \"" + name + "\"");
  if (!like.no_loop.empty() && kind->of_loop) {
    std::vector<const char*> others;
    for (const ModelKind& other : kModelKinds)
      if (!other.of_loop) others.push_back(other.name);
    throw AnalysisError(
        "TB-ANALYSIS-NO-LOOP", name + " is made of the external loop: " + like.no_loop,
        fmt::format("measure from the lowest to the highest level and back without a reversal between, or fit a model "
                    "that needs no external loop: --model {}",
                    fmt::join(others, ",")));
  }
  if (!options.linearise) return kind->prepare(like, options);
  // The congruency test is about Preisach's kind of model, and tells of it what held branches would: there errors are
  // more of weights that the others leave open.
  return prepare_linearised(like, options.free_run, name != PreisachModel::kName,
                            [&](const FitData& data) { return kind->prepare(data, options); });
}

ModelFit identify(const std::string& name, const FitData& data, const IdentifyOptions& options) {
  return prepare(name, data, options)->fit(data);
}

bool begins_falling(const History& history) {
  return !history.branches.empty() && history.branches.front().first == 0 && !history.branches.front().ascending;
}

// Samples outside of any branch are walked one by one. Within a branch the way is the one from its first sample: an
// input that steps back there (noise of a measured reference) is no turn.
std::vector<double> predict_history(const HysteresisModel& model, const History& history, bool free_run) {
  const auto state = model.state();
  if (begins_falling(history)) state->go(model.x_high());
  std::vector<double> outputs(history.x.size());
  std::size_t next = 0;
  const auto walk_to = [&](std::size_t end) {
    for (; next < end; ++next) {
      state->go(history.x[next]);
      outputs[next] = state->output_at(history.x[next]);
    }
  };
  for (const Branch& branch : history.branches) {
    const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
    walk_to(first);
    state->go(history.x[first]);
    if (!free_run) state->measured(history.y[first]);
    for (std::size_t i = next; i <= last; ++i) outputs[i] = state->output_at(history.x[i]);
    state->go(history.x[last]);
    next = last + 1;
  }
  walk_to(history.x.size());
  return outputs;
}

}  // namespace tactbench::analysis
