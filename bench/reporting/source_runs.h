// Runs that models were made from: the fitted run and, for a dynamic model, those that lag and creep were taken from.
// None of them is independent data for the models.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "db/run_store.h"

namespace tactbench::bench {

// The number in this store of a run that lag or creep was taken from. Runs get new numbers in a copy of a store: the
// run is identified by its content, and by its number only where the model does not state the content. None: the store
// does not have it.
std::optional<std::int64_t> run_of_source(const db::RunStore& store, const analysis::SensorDynamics::Source& source);

// Each once, the fitted run first; what this store does not have is left out.
std::vector<std::int64_t> source_runs(const db::RunStore& store, const analysis::SensorModel& fit);

}  // namespace tactbench::bench
