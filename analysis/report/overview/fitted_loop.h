// Charts of a measured loop with the loops of models drawn over it, and of a model's residuals: for the mean taxel, or
// the only one.
#pragma once

#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/page/chart.h"

namespace tactbench::analysis {

// `models`: made from or checked on these data; the first four are drawn. Pressures in `unit`, other inputs as they
// are.
Chart fitted_loop(const Histories& histories, const std::vector<const SensorModel*>& models, PressureUnit unit);
// Measured outputs less the model's, in % of full scale, over the inputs.
Chart fitted_errors(const Histories& histories, const SensorModel& model, PressureUnit unit);

}  // namespace tactbench::analysis
