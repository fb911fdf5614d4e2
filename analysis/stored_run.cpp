#include "analysis/stored_run.h"

namespace tactbench::analysis {

StoredRun read_run(const db::RunStore& store, const db::RunRecord& record) {
  return {record, store.frames(record.run), store.branches(record.run), store.events(record.run),
          store.checks(record.run)};
}

}  // namespace tactbench::analysis
