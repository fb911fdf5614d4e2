// Merges several stores into one: runs, figures, baselines, and the parts of a nightly run that several machines
// carried out. The merged night equals that of one machine: the same runs under the same numbers, figures, comparisons.
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
  bool there = false;  // was in the store already
};

struct MergedStores {
  std::size_t runs = 0, there = 0;  // taken, and in the store already
  std::size_t fits = 0;             // taken of runs that were there
  std::size_t baselines = 0;
  std::vector<MergedNight> nights;  // of the parts, taken now or there already
};

// Takes from `parts` what `store` does not have. Runs are known by UUID, so that merging again, also after a merge that
// was cut off, adds what is missing alone. Nights come last, in the order of their beginnings, each in its suite's
// order. Throws Error TB-MERGE-SHARD when a night's parts are not all there, or one is there twice; nothing is taken
// then. StoreError TB-STORE-CONFLICT when a run's content is not what was stored, or differs from the run of the same
// UUID.
MergedStores merge_stores(const std::vector<std::string>& parts, db::RunStore& store);

}  // namespace tactbench::bench
