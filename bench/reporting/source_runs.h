// The runs that models were made from: the fitted one, and of a dynamic model those that its lag and creep were taken
// from. None of them is independent data for the models, and the models rest on each of them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "db/run_store.h"

namespace tactbench::bench {

// The number that a source of lag or creep has in this store. A copy numbers runs anew: the run is known by its
// content, and by its number alone where the model does not tell the content. None: the store does not have it.
std::optional<std::int64_t> run_of_source(const db::RunStore& store, const analysis::SensorDynamics::Source& source);

// Each once, the fitted run first; what this store does not have is left out.
std::vector<std::int64_t> source_runs(const db::RunStore& store, const analysis::SensorModel& fit);

}  // namespace tactbench::bench
