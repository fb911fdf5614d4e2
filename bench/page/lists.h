// Lists of the store's runs and sensors for the page, with their verdicts.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/report/laboratory.h"
#include "bench/reporting/judgement.h"
#include "db/run_store.h"

namespace tactbench::bench {

inline constexpr std::size_t kListedRuns = 500;  // the newest

// Members word, of_means, models_of, decided: the verdict, whether it is by mean errors alone, the run whose models
// were judged, and the deciding figure as text. Null without a verdict.
nlohmann::ordered_json verdict_json(const Standing& stands);
// The verdict that is valid for the models by which `run` was judged, or that were made from it: over all runs that
// they were judged on.
Standing calibration_of(const db::RunStore& store, std::int64_t run);
// Newest first, void ones too; `left_out`: older ones. `report`: reporting_run().
nlohmann::ordered_json runs_list(const db::RunStore& store);
// With the numbers of each sensor's runs, newest first; its last calibration's verdict, day, and the day until which it
// counts by `laboratory`, overdue on `today` (2026-01-31); and whether figures of it are kept.
nlohmann::ordered_json sensors_list(const db::RunStore& store, const analysis::Laboratory& laboratory,
                                    const std::string& today);
// Of how many scenarios the store keeps figures.
std::size_t stored_nights(const db::RunStore& store);

}  // namespace tactbench::bench
