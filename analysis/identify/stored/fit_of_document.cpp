#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/elam_hysteresis.h"

namespace tactbench::analysis {
namespace {

PatternCurve adjusted(const PatternCurve& curve, const ModelTaxel& taxel) {
  if (taxel.zero == 0.0 && taxel.gain == 1.0) return curve;
  std::vector<double> y;
  for (const double output : curve.y()) y.push_back(taxel.zero + taxel.gain * output);
  return {curve.x(), y, y.front(), y.back()};
}

AnalysisError no_array(const ModelDocument& document, const std::string& why) {
  return {Cause::kUsage, "TB-MODEL-COMPENSATOR",
          fmt::format("{} of {} cannot compensate frames: {}", label_of(document), document.source, why),
          "fit ELAM on a run of the array: tactbench fit RUN"};
}

TaxelFit taxel_fit_of(const ModelDocument& document, const ModelTaxel& taxel) {
  TaxelFit out;
  out.noise_v = taxel.noise;
  for (const TaxelStatus status :
       {TaxelStatus::kFitted, TaxelStatus::kDead, TaxelStatus::kStuck, TaxelStatus::kSaturated, TaxelStatus::kUnfit})
    if (taxel.status == to_string(status)) out.status = status;
  if (taxel.fit.model == nullptr) {
    if (out.status == TaxelStatus::kFitted) out.status = TaxelStatus::kUnfit;
    return out;
  }
  const auto* model = dynamic_cast<const ElamHysteresis*>(taxel.fit.model.get());
  if (model == nullptr || !model->is_paper()) throw no_array(document, "only ELAM as in the paper is streamed");
  out.status = TaxelStatus::kFitted;
  out.fit.model = {adjusted(model->elam().ascending, taxel), adjusted(model->elam().descending, taxel),
                   model->elam().parameters, model->elam().options};
  out.fit.j_v2 = taxel.fit.j;
  out.fit.mean_error_v = taxel.fit.mean_error;
  out.fit.max_error_v = taxel.fit.max_error;
  for (const PatternCurve* curve : {&out.fit.model.ascending, &out.fit.model.descending})
    for (const double y : curve->y()) out.fit.full_scale_v = std::max(out.fit.full_scale_v, std::abs(y));
  return out;
}

}  // namespace

ArrayFit array_fit_of(const ModelDocument& document) {
  ArrayFit fit;
  fit.rows = document.rows;
  fit.columns = document.columns;
  fit.origin = document.origin;
  fit.sensor_serial = document.sensor_serial;
  fit.scanner_serial = document.scanner_serial;
  fit.falling = document.falling;
  for (const ModelTaxel& taxel : document.taxels) {
    TaxelFit own;
    try {
      own = taxel_fit_of(document, taxel);
    } catch (const std::invalid_argument& error) {
      throw no_array(document, fmt::format("taxel {}: {}", taxel.taxel, error.what()));
    }
    if (own.status == TaxelStatus::kFitted && fit.pressure_psi.empty()) {
      const auto grid = own.fit.model.ascending.x();
      fit.pressure_psi.assign(grid.begin(), grid.end());
    }
    if (taxel.taxel == kMeanTaxel)
      fit.mean_taxel = std::move(own);
    else
      fit.taxels.push_back(std::move(own));
  }
  if (fit.taxels.size() != static_cast<std::size_t>(document.rows) * static_cast<std::size_t>(document.columns) ||
      fit.mean_taxel.status != TaxelStatus::kFitted)
    throw no_array(document, "it is not of a whole array with its mean");
  fit.full_scale_v = fit.mean_taxel.fit.full_scale_v;
  return fit;
}

}  // namespace tactbench::analysis
