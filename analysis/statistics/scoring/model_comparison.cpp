#include "analysis/statistics/scoring/model_comparison.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

const ModelTaxel& fit_of(const SensorModel& fit, int taxel) {
  return taxel == kMeanTaxel ? fit.mean_taxel() : fit.taxels[static_cast<std::size_t>(taxel)];
}

History history_on(const std::string& name, const TaxelTable& common, const Fitted& fitted, int taxel) {
  History history{name, common.pressure_psi, {}, common.branches, {}, {}};
  for (std::size_t i = 0; i < common.pressure_psi.size(); ++i) {
    history.y.push_back(taxel == kMeanTaxel ? mean_of(fitted.row(common.values, i))
                                            : common.values[i * fitted.width() + static_cast<std::size_t>(taxel)]);
  }
  return history;
}

// Walks the model along the history and takes its errors.
ComparedModel walked(const HysteresisModel& model, const History& history) {
  ComparedModel out;
  out.model = model.name();
  out.parameters = model.parameters();
  out.operations_per_sample = model.operations_per_sample();
  out.model_v = predict_history(model, history, false);
  const std::vector<double> running = predict_history(model, history, true);
  double sum = 0.0;
  for (const Branch& branch : history.branches) {
    for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i) {
      const double off = std::abs(out.model_v[i] - history.y[i]);
      out.j_v2 += off * off;
      sum += off;
      out.max_error_v = std::max(out.max_error_v, off);
      out.mean_running_v += std::abs(running[i] - history.y[i]);
      out.max_running_v = std::max(out.max_running_v, std::abs(running[i] - history.y[i]));
      ++out.samples;
    }
  }
  if (out.samples > 0) out.mean_error_v = sum / out.samples;
  if (out.samples > 0) out.mean_running_v /= out.samples;
  return out;
}

// Identification of one model on one sequence: what depends on the inputs alone is made once for all taxels.
struct SharedIdentifier {
  std::unique_ptr<Identifier> identifier;
  std::string failed;
};

SharedIdentifier prepare_shared(const std::string& model, const TaxelHistories& like, const std::string& sequence) {
  SharedIdentifier out;
  try {
    out.identifier = prepare(model, fit_data_of(like, {sequence}));
  } catch (const std::invalid_argument& error) {
    out.failed = error.what();
  } catch (const AnalysisError& error) {
    out.failed = error.what();
  }
  return out;
}

ComparedModel identified(const char* model, const SharedIdentifier& shared, const TaxelHistories& taxel,
                         const History& history) {
  ComparedModel out;
  out.model = model;
  out.failed = shared.failed;
  if (shared.identifier == nullptr) return out;
  try {
    return walked(*shared.identifier->fit(fit_data_of(taxel, {history.name})).model, history);
  } catch (const std::invalid_argument& error) {
    out.failed = error.what();
  } catch (const AnalysisError& error) {
    out.failed = error.what();
  }
  return out;
}

void negate_outputs(ComparedSequence& sequence) {
  for (double& v : sequence.measured_v) v = -v;
  for (ComparedModel& model : sequence.models)
    for (double& v : model.model_v) v = -v;
}

}  // namespace

ModelComparison compare_models(const Dataset& measured, const SensorModel& fit, const ChosenTaxels& chosen,
                               int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const Fitted fitted(fit);
  std::vector<TaxelTable> common;
  for (const SequenceData& sequence : dataset.sequences) common.push_back(bring_to_common(sequence, dataset.taxels()));

  ModelComparison out;
  std::vector<TaxelHistories> histories;
  for (const NamedTaxel& named : named_taxels(chosen, fit.columns)) {
    if (fit_of(fit, named.taxel).status != TaxelStatus::kFitted) continue;
    ComparedTaxel& taxel = out.taxels.emplace_back();
    taxel.taxel = named;
    taxel.full_scale_v = fit_of(fit, named.taxel).full_scale();
    TaxelHistories& own = histories.emplace_back();
    own.taxel = named.taxel;
    for (std::size_t s = 0; s < common.size(); ++s) {
      own.fit.push_back(history_on(dataset.sequences[s].name, common[s], fitted, named.taxel));
      taxel.sequences.push_back({own.fit.back().name, own.fit.back().x, own.fit.back().y, {}});
    }
  }
  if (out.taxels.empty()) return out;
  // The last is ELAM: the one of the fit, where that is ELAM.
  const bool own_elam = elam_of(fit.mean_taxel()) != nullptr;
  constexpr std::size_t kModels = std::size(kComparedModels);
  const std::size_t others = own_elam ? kModels - 1 : kModels;
  std::vector<SharedIdentifier> shared(common.size() * others);
  for_each_index(shared.size(), threads, [&](std::size_t i) {
    shared[i] = prepare_shared(kComparedModels[i % others], histories.front(), dataset.sequences[i / others].name);
  });
  for (ComparedTaxel& taxel : out.taxels)
    for (ComparedSequence& sequence : taxel.sequences) sequence.models.resize(kModels);
  // The longest work first would be fairer; there are so few pieces that it does not matter.
  for_each_index(out.taxels.size() * common.size() * others, threads, [&](std::size_t i) {
    const std::size_t model = i % others, s = i / others % common.size(), t = i / others / common.size();
    out.taxels[t].sequences[s].models[model] =
        identified(kComparedModels[model], shared[s * others + model], histories[t], histories[t].fit[s]);
  });
  for (std::size_t t = 0; t < out.taxels.size(); ++t) {
    for (std::size_t s = 0; s < common.size(); ++s) {
      ComparedSequence& sequence = out.taxels[t].sequences[s];
      if (own_elam) {
        sequence.models.back() = walked(*fit_of(fit, out.taxels[t].taxel.taxel).fit.model, histories[t].fit[s]);
        sequence.models.back().joint = common.size() > 1;
      }
      if (fit.falling) negate_outputs(sequence);
    }
  }
  return out;
}

}  // namespace tactbench::analysis
