#include "analysis/statistics/scoring/model_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/folds.h"
#include "analysis/workers.h"

namespace tactbench::analysis {

namespace {

std::string units_of(const std::string& input, const std::string& output) {
  if (input.empty() && output.empty()) return "no units stated";
  return fmt::format("the input unit {} and the output unit {}", or_not_stated(input), or_not_stated(output));
}

}  // namespace

void check_same_source(const SensorModel& document, const Histories& histories) {
  if (document.dynamics)
    throw AnalysisError(Cause::kUsage, "TB-MODEL-DYNAMIC",
                        fmt::format("the dynamic model of {} is not compared with samples that tell no times, nor "
                                    "adjusted by them: its lag and creep would count as errors",
                                    document.source),
                        "judge it on runs, which tell the times: tactbench fit RUN --model dynamic --rate RUN --creep "
                        "RUN --held-out RUN; where the sensor has changed, fit it again");
  if (document.origin != histories.origin)
    throw AnalysisError(
        "TB-ANALYSIS-ORIGIN",
        fmt::format("the model is of {} data and {} is {}", document.origin, histories.source, histories.origin),
        "origins are never mixed: score on data of the same one");
  if (document.sensor_serial != histories.sensor_serial || document.scanner_serial != histories.scanner_serial)
    throw AnalysisError(
        "TB-ANALYSIS-OTHER-SENSOR",
        fmt::format("the model belongs to sensor {} on scanner {}, {} to {} on {}",
                    or_not_stated(document.sensor_serial), or_not_stated(document.scanner_serial), histories.source,
                    or_not_stated(histories.sensor_serial), or_not_stated(histories.scanner_serial)),
        "score on runs of the sensor that was fitted");
  if (document.input_unit != histories.input_unit || document.output_unit != histories.output_unit)
    throw AnalysisError(Cause::kUsage, "TB-MODEL-UNITS",
                        fmt::format("the model has {}, {} has {}", units_of(document.input_unit, document.output_unit),
                                    histories.source, units_of(histories.input_unit, histories.output_unit)),
                        "give the units of the table: --input-unit U --output-unit U");
  if (document.falling != histories.falling)
    throw AnalysisError("TB-ANALYSIS-FALLING",
                        fmt::format("the output of the model {} with the input, that of {} does not",
                                    document.falling ? "falls" : "rises", histories.source),
                        "check the polarity of the wiring and the assignment of the columns");
}

namespace {

Score score_taxel(const ModelTaxel& model, const TaxelHistories& taxel, const std::vector<std::string>& sequences) {
  std::vector<History> histories = named(taxel.score, sequences);
  for (History& history : histories)
    for (double& y : history.y) y = (y - model.zero) / model.gain;
  const HysteresisModel& own = *model.fit.model;
  ScoreOptions options;
  options.dead_band = kBandInNoises * model.noise / model.gain;
  options.x_low = own.x_low();
  options.x_high = own.x_high();
  options.y_low = model.loop_low;
  options.y_high = model.loop_low + model.fit.full_scale;
  return score(own, histories, options);
}

}  // namespace

ModelScore score_model(const SensorModel& document, const Histories& histories,
                       const std::vector<std::string>& sequences, int threads) {
  check_same_source(document, histories);
  std::vector<Score> scores(document.taxels.size());
  for_each_index(scores.size(), threads, [&](std::size_t i) {
    const ModelTaxel& model = document.taxels[i];
    const auto own = std::ranges::find(histories.taxels, model.taxel, &TaxelHistories::taxel);
    if (model.fit.model == nullptr || own == histories.taxels.end() || !own->usable()) return;
    scores[i] = score_taxel(model, *own, sequences);
  });
  ModelScore result;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const ModelTaxel& model = document.taxels[i];
    if (scores[i].direct.samples == 0) continue;
    if (model.taxel == kMeanTaxel || document.taxels.size() == 1) {
      result.mean = scores[i];
      result.full_scale = model.fit.full_scale;
    }
    if (model.taxel == kMeanTaxel && document.taxels.size() > 1) continue;
    result.taxels.add(scores[i]);
    ++result.count;
  }
  if (result.count == 0)
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL",
                        fmt::format("the model of {} and {} have no taxel in common that can be scored",
                                    document.source, histories.source),
                        "score on data of the array that was fitted");
  return result;
}

ErrorSum cross_validate(const std::string& model, const FitData& data, const IdentifyOptions& options, int folds) {
  ErrorSum errors;
  for (const Fold& fold : folds_of(data, folds)) {
    ModelFit fit;
    try {
      fit = identify(model, with_branches(data, fold.kept), options);
    } catch (const std::invalid_argument&) {
      return {};  // a part without branches of both directions carries no model
    }
    const FitData held = with_branches(data, fold.held);
    for (const History& history : held.histories) {
      if (history.branches.empty()) continue;
      const std::vector<double> predicted = predict_history(*fit.model, history, options.free_run);
      for (const Branch& branch : history.branches)
        for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i)
          errors.add(std::abs(predicted[i] - history.y[i]));
    }
  }
  return errors;
}

}  // namespace tactbench::analysis
