// Makes sensor models from given taxels.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis::by_hand {

// A fitted taxel of ELAM whose external loop is the two patterns.
inline ModelTaxel elam_taxel(const PatternCurve& ascending, const PatternCurve& descending,
                             const ElamParameters& parameters = {}) {
  ModelTaxel taxel;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::make_shared<ElamHysteresis>(ElamModel{ascending, descending, parameters, {}});
  taxel.ascending = ascending;
  taxel.descending = descending;
  taxel.loop_low = taxel.y0();
  taxel.fit.full_scale = taxel.yu() - taxel.y0();
  return taxel;
}

inline ModelTaxel left_out(TaxelStatus status) {
  ModelTaxel taxel;
  taxel.status = status;
  return taxel;
}

// Numbers the taxels and puts the mean behind them, in the place of one that is there.
inline void finish(SensorModel& fit, ModelTaxel mean) {
  if (!fit.taxels.empty() && fit.taxels.back().taxel == kMeanTaxel) fit.taxels.pop_back();
  for (std::size_t i = 0; i < fit.taxels.size(); ++i) fit.taxels[i].taxel = static_cast<int>(i);
  mean.taxel = kMeanTaxel;
  fit.taxels.push_back(std::move(mean));
}

}  // namespace tactbench::analysis::by_hand
