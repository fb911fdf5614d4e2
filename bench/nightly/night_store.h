// Stores nightly runs: copies the runs of each scenario into one store and compares the results with baselines and
// earlier nights.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/nightly/scenario.h"
#include "bench/nightly/subject_trend.h"
#include "db/run_store.h"

namespace tactbench::bench {

// The subject under which a scenario's figures are tracked.
std::string subject_of(const Scenario& scenario);  // "nightly/NAME"

// The store that holds a result's runs under the numbers of the result.
using StoreOfResult = std::function<db::RunStore(const ScenarioResult&)>;
// For a night on this machine: each scenario has made a store `folder`/NAME.db.
StoreOfResult in_stores_of(const std::string& folder);

// Copies the runs of `results` into `store`, in the suite's order, with tag and figures, and adds `night` with the
// results; numbers in `results` become those of `store`. Skips what the store already has; returns false if it had
// everything. `suite`: the complete suite; `results` may be a part of it. Throws StoreError, e.g. TB-STORE-CONFLICT if
// a run's content has changed since it was stored.
bool store_night(db::NightRecord night, const Suite& suite, std::vector<ScenarioResult>& results,
                 const StoreOfResult& store_of, db::RunStore& store);

// Compares each result in `store` with the last one of the same seeds, frame by frame: frames that changed, and figures
// that changed although the frames did not, are added to `remarks`. Figures outside their baseline are added to
// `wrong`; figures that shifted, judged over the whole night, to `remarks`. Skips scenarios without a run. Returns the
// tracked figures of each scenario with a run; several seeds of a scenario count as one.
std::vector<SubjectTrend> compare_night(const Suite& suite, std::vector<ScenarioResult>& results,
                                        const db::RunStore& store);

// Copies to a store what another store recorded about a run after its end: fits, verdicts by them, figures.

// Run `there` of `other` and run `here` of `store` have the same content. Copies the fits that `store` does not have,
// with their verdicts on this run, and the figures of subjects that have none here. Returns the number of fits. Throws
// StoreError TB-STORE-CONFLICT if they have changed since they were stored.
std::size_t copy_fits(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here);

}  // namespace tactbench::bench
