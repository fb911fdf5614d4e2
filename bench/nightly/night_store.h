// The store that keeps nights: imports each scenario's runs and compares the results with baselines and earlier nights.
#pragma once

#include <string>
#include <vector>

#include "bench/nightly/followed.h"
#include "bench/nightly/scenario.h"
#include "db/run_store.h"

namespace tactbench::bench {

// The subject under which a scenario's figures are followed.
std::string subject_of(const Scenario& scenario);  // "nightly/NAME"

// Copies the runs of `results` from `stores`/NAME.db in the suite's order, with tag and figures; numbers in `results`
// become those of `store`. Compares each result with the last one of the same seeds, frame by frame: frames that
// changed, and figures that changed though the frames did not, go to `remarks`. Adds figures outside their baseline to
// `wrong`, and those that shifted, judged over the whole night, to `remarks`. Skips scenarios without a result. Throws
// StoreError, e.g. TB-STORE-CONFLICT when a run's content is not what was stored. Returns the followed figures of each
// scenario with a result, once for several seeds.
std::vector<Followed> keep_night(const Suite& suite, std::vector<ScenarioResult>& results, const std::string& stores,
                                 db::RunStore& store);

}  // namespace tactbench::bench
