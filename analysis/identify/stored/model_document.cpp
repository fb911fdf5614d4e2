#include "analysis/identify/stored/model_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/identify/identifier.h"
#include "analysis/workers.h"

namespace tactbench::analysis {

const ModelTaxel& ModelDocument::taxel(int number) const {
  const auto found = std::ranges::find(taxels, number, &ModelTaxel::taxel);
  if (found != taxels.end()) return *found;
  throw AnalysisError(Cause::kUsage, "TB-MODEL-TAXEL",
                      fmt::format("the model of {} has no taxel {}; it has {} of them", source, number, taxels.size()),
                      "name one of these with --taxel, or give the table a column that does");
}

double ModelDocument::to_model(const ModelTaxel& own, double output) const {
  return ((falling ? -output : output) - own.zero) / own.gain;
}

double ModelDocument::from_model(const ModelTaxel& own, double output) const {
  const double rising = own.zero + own.gain * output;
  return falling ? -rising : rising;
}

namespace {

// Taxels of a run share their inputs; those of a table need not.
bool alike(const FitData& a, const FitData& b) {
  return std::ranges::equal(a.histories, b.histories, {}, &History::x, &History::x) &&
         std::ranges::equal(a.ascending.x(), b.ascending.x());
}

}  // namespace

ModelDocument fit_models(const std::string& model, const Histories& histories,
                         const std::vector<std::string>& sequences, const IdentifyOptions& options, int threads) {
  ModelDocument document;
  document.model = model;
  document.options = options;
  document.source = histories.source;
  document.origin = histories.origin;
  document.content_sha256 = histories.content_sha256;
  document.sequences = sequences.empty() ? histories.sequences : sequences;
  document.sensor_serial = histories.sensor_serial;
  document.scanner_serial = histories.scanner_serial;
  document.input_unit = histories.input_unit;
  document.output_unit = histories.output_unit;
  document.rows = histories.rows;
  document.columns = histories.columns;
  document.scans = histories.scans;
  document.falling = histories.falling;
  const auto first = std::ranges::find_if(histories.taxels, [](const auto& t) { return t.status.empty(); });
  const FitData like = fit_data_of(*first, sequences);
  document.validity = validity_of(named(first->score, sequences), histories.temperatures_c);
  document.taxels.resize(histories.taxels.size());
  std::unique_ptr<Identifier> shared;
  try {
    shared = prepare(model, like, options);
  } catch (const std::invalid_argument& error) {
    throw AnalysisError("TB-ANALYSIS-MODEL",
                        fmt::format("{}: {} cannot be fitted: {}", histories.source, model, error.what()),
                        "fit sequences that hold what is missing, or another model");
  }
  for_each_index(histories.taxels.size(), threads, [&](std::size_t i) {
    const TaxelHistories& own = histories.taxels[i];
    ModelTaxel& taxel = document.taxels[i];
    taxel.taxel = own.taxel;
    taxel.noise = own.noise;
    if (!own.status.empty()) {
      taxel.status = own.status;
      return;
    }
    try {
      const FitData data = fit_data_of(own, sequences);
      taxel.loop_low = data.ascending.y().front();
      taxel.fit = alike(data, like) ? shared->fit(data) : identify(model, data, options);
    } catch (const std::invalid_argument& error) {
      taxel.status = error.what();
    } catch (const AnalysisError& error) {
      taxel.status = error.what();
    }
  });
  if (std::ranges::none_of(document.taxels, [](const ModelTaxel& t) { return t.fit.model != nullptr; }))
    throw AnalysisError("TB-ANALYSIS-MODEL",
                        fmt::format("{}: {} cannot be fitted: {}", histories.source, model,
                                    document.taxels[static_cast<std::size_t>(first - histories.taxels.begin())].status),
                        "fit sequences that hold what is missing, or another model");
  return document;
}

}  // namespace tactbench::analysis
