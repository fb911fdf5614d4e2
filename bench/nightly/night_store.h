// Stores nightly runs: copies the runs of each scenario into one store, compares the results with baselines and earlier
// nights, and merges the stores of several machines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/nightly/subject_trend.h"
#include "bench/nightly/suite.h"
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
std::size_t copy_fits(const db::RunStore& other, std::int64_t there, db::Models& store, std::int64_t here);

// Merges several stores into one: runs, figures, baselines, and the parts of a nightly run that several machines
// carried out. The merged night equals the night of one machine: the same runs with the same numbers, figures and
// comparisons.
struct MergedNight {
  db::NightRecord record;  // without results
  Suite suite;             // with its seeds
  std::vector<ScenarioResult> results;
  std::vector<SubjectTrend> followed;
  bool there = false;  // was already in the store
};

struct MergedStores {
  std::size_t runs = 0, there = 0;  // runs: copied; there: already in the store
  std::size_t fits = 0;             // fits copied for runs that were already in the store
  std::size_t baselines = 0;
  std::vector<MergedNight> nights;  // nights of the parts, copied now or already in the store
};

// Copies from `parts` the runs that `store` does not have. Runs are identified by UUID, so that repeating a merge, also
// an interrupted one, adds only missing runs. Nights come last, in the order of their start, each in its suite's order.
// Throws Error TB-MERGE-SHARD if a part of a night is missing or there twice; nothing is copied then. StoreError
// TB-STORE-CONFLICT if a run's content has changed since it was stored, or differs from the run with the same UUID.
MergedStores merge_stores(const std::vector<std::string>& parts, db::RunStore& store);

}  // namespace tactbench::bench
