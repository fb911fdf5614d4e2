// A sensor of one taxel whose model has lag and creep: a film of three cells.
#pragma once

#include <memory>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"

namespace tactbench::creeping {

// Two intervals from 10 to 50 psi: cells of 1, 2 and 4 V behind a divider.
inline analysis::SensorModel creeping_film(bool falling = false) {
  using namespace analysis;
  SensorModel model;
  model.source = "run 5";
  model.rows = model.columns = 1;
  model.falling = falling;
  model.dynamics.emplace();
  model.dynamics->shared.creep_share = {0.03, 0.02, 0.01};
  model.dynamics->shared.lag_share = 0.1;
  model.dynamics->shared.lag_s = 3.0;
  ModelTaxel& taxel = model.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.status = TaxelStatus::kFitted;
  taxel.noise = 0.002;
  taxel.creep_scale = 1.5;
  taxel.lag_share = 0.1;
  taxel.fit.full_scale = 7.0 / (1.0 + 7.0 / 8.0);
  taxel.loop_low = 0.5;
  taxel.fit.model = std::make_shared<LinearisedModel>(
      Divider{0.5, 0.125}, std::make_shared<PreisachModel>(10.0, 50.0, 0.0, std::vector<double>{1, 2, 4}));
  return model;
}

}  // namespace tactbench::creeping
