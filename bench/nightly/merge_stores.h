// Merges several stores into one: runs, figures, baselines, and the parts of a nightly run that several machines
// carried out. The merged night equals the night of one machine: the same runs with the same numbers, figures and
// comparisons.
#pragma once

#include <string>
#include <vector>

#include "bench/nightly/scenario.h"
#include "bench/nightly/subject_trend.h"
#include "db/run_store.h"

namespace tactbench::bench {

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
