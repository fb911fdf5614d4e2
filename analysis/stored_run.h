// All rows that the store holds of one run, read at once: input of a Dataset, its presses, its event log and the rig's
// figures.
#pragma once

#include <vector>

#include "db/run_store.h"

namespace tactbench::analysis {

struct StoredRun {
  db::RunRecord record;
  std::vector<db::FrameRecord> frames;  // in the order written, those of void branches among them
  std::vector<db::BranchRecord> branches;
  std::vector<db::EventRecord> events;
  std::vector<db::CheckRecord> checks;
};

// `record`: the run's row, as RunStore::run() gives it. Throws StoreError.
StoredRun read_run(const db::RunStore& store, const db::RunRecord& record);

}  // namespace tactbench::analysis
