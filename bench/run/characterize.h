// Carries out one run from the request to the closed run record. Order: checks before any device is touched; the run's
// row in the store before the first device is opened; setup; steps; and a teardown that always tries to prove the safe
// state and records why the run ended.
#pragma once

#include "bench/run/control/progress.h"
#include "bench/run/run_record.h"
#include "db/run_store.h"

namespace tactbench::bench {

// Throws (FileError, StoreError, Error) only before the run's row is made or reopened; later errors are in the result.
RunResult characterize(const RunRequest& request, db::RunStore& store, Progress& progress);

}  // namespace tactbench::bench
