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

// The subject under which a scenario's figures are followed.
std::string subject_of(const Scenario& scenario);  // "nightly/NAME"

// The store in which a result's runs lie, under the numbers that the result has.
using StoreOfResult = std::function<db::RunStore(const ScenarioResult&)>;
// A night's own: each scenario has made a store `folder`/NAME.db.
StoreOfResult in_stores_of(const std::string& folder);

// Copies the runs of `results` into `store`, in the suite's order, with tag and figures, and adds `night` with the
// results; numbers in `results` become those of `store`. What is there already is not taken again; false: all of it
// was. `suite`: the whole one, of which `results` may be a part. Throws StoreError, e.g. TB-STORE-CONFLICT when a run's
// content is not what was stored.
bool store_night(db::NightRecord night, const Suite& suite, std::vector<ScenarioResult>& results,
                 const StoreOfResult& store_of, db::RunStore& store);

// Compares each result in `store` with the last one of the same seeds, frame by frame: frames that changed, and figures
// that changed though the frames did not, go to `remarks`. Adds figures outside their baseline to `wrong`, and those
// that shifted, judged over the whole night, to `remarks`. Skips scenarios without a run. Returns the followed figures
// of each scenario with a run, once for several seeds.
std::vector<SubjectTrend> compare_night(const Suite& suite, std::vector<ScenarioResult>& results,
                                        const db::RunStore& store);

// Copies to a store what another store recorded about a run after its end: fits, verdicts by them, figures.

// Run `there` of `other` and run `here` of `store` have the same content. Takes the fits that `store` does not have,
// with the verdicts on this run by them, and the figures of subjects that have none here. Returns the number of fits.
// Throws StoreError TB-STORE-CONFLICT when they are not what was stored.
std::size_t copy_fits(const db::RunStore& other, std::int64_t there, db::RunStore& store, std::int64_t here);

}  // namespace tactbench::bench
