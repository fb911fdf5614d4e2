// The store that keeps nights: takes in each scenario's runs, and holds what came out against baselines and the nights
// before.
#pragma once

#include <string>
#include <vector>

#include "bench/nightly/followed.h"
#include "bench/nightly/scenario.h"
#include "db/run_store.h"

namespace tactbench::bench {

// What is followed of a scenario.
std::string subject_of(const Scenario& scenario);  // "nightly/NAME"

// Copies the runs of `results` from `stores`/NAME.db in the suite's order, with tag and figures; numbers in `results`
// become those of `store`. Says in each result whether the run's content is that of the last night with its seed, adds
// figures outside their baseline to `wrong`, and drifts to `remarks`. A scenario without a result has nothing to take.
// Throws StoreError, e.g. TB-STORE-CONFLICT when a run's content is not what was stored. Returns what is followed of
// each scenario that came out, once where it has several seeds.
std::vector<Followed> keep_night(const Suite& suite, std::vector<ScenarioResult>& results, const std::string& stores,
                                 db::RunStore& store);

}  // namespace tactbench::bench
