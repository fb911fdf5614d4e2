// Lists of the store's runs and sensors for the page, with their verdicts.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/report/laboratory.h"
#include "bench/reporting/judgement.h"
#include "db/run_store.h"

namespace tactbench::bench {

inline constexpr std::size_t kListedRuns = 500;  // the newest runs

// Members word, of_means, models_of, decided: the verdict, whether it is based on mean errors alone, the run whose
// models were judged, and the deciding figure as text. Null without a verdict.
nlohmann::ordered_json verdict_json(const Standing& stands);
// The valid verdict for the models by which `run` was judged, or that were made from it, over all runs on which they
// were judged.
Standing calibration_of(const db::RunStore& store, std::int64_t run);
// Newest first, including void runs; `left_out`: number of older runs. `report`: reporting_run().
nlohmann::ordered_json runs_list(const db::RunStore& store);
// Each sensor with the numbers of its runs, newest first; verdict and day of its last calibration, the day until which
// it is valid by `laboratory`, and whether it is overdue on `today` (2026-01-31); and whether figures of the sensor are
// stored.
nlohmann::ordered_json sensors_list(const db::RunStore& store, const analysis::Laboratory& laboratory,
                                    const std::string& today);
// Number of scenarios for which the store has figures.
std::size_t stored_nights(const db::RunStore& store);

}  // namespace tactbench::bench
