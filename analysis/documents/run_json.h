// A run, its sensor and its evaluation as JSON. All outputs use these keys for the facts about a run: `runs show
// --json` and other verbs, `runs export`, the data of reports and the attributes of HDF5 files.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "db/record.h"

namespace tactbench::analysis {

// Version of the schema tactbench.run, a run exported as JSON or HDF5. 2: the root of an HDF5 file also has these keys.
inline constexpr int kRunSchemaVersion = 2;

// Every key is always present. Empty texts: not known; `overrides` and `rest_s` are then null. Instruments'
// calibrations are completed with `notes` (instruments.h); a value that still says FILL-IN counts as not
// stated. Recipes stand in the order of the run's sequences.
nlohmann::ordered_json run_json(const db::RunRecord& run, std::span<const InstrumentNote> notes = {});

nlohmann::ordered_json sensor_json(const db::SensorRecord& sensor);

// Metadata of a run as KEY=VALUE pairs: lot, order and others. They are the run's tags that contain "="; like all tags
// they are remarks and not part of the run's content (db/hash_chain.h).
std::map<std::string, std::string> metadata_of(const db::RunRecord& run);

// Figures of a run as JSON, for verbs and for the data of reports. The run itself is not included: a verb adds the
// run's number, a report its title.
// Keys that end in _fs: shares of full scale.
//   frames full_scale_v full_scale_psi hysteresis_max_fs hysteresis_mean_fs mean_error_psi max_error_psi
//   mean_error_observable_psi max_error_observable_psi worst_taxel_mean_error_psi worst_taxel raw_distance_fs
//   comp_distance_of_mean_fs comp_distance_fs comp_distance_observable_fs worst_taxel_distance_fs
//   worst_taxel_distance_observable_fs flat_share levels_made_worse_psi
nlohmann::ordered_json evaluation_json(const Evaluation& evaluation);

}  // namespace tactbench::analysis
