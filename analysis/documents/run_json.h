// A run and its sensor as JSON. All outputs use these keys for the facts of a run: `runs show --json` and other verbs,
// `runs export`, the data of reports and the attributes of HDF5 files.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "db/record.h"

namespace tactbench::analysis {

// Of the schema tactbench.run, a run exported as JSON or HDF5. 2: the root of an HDF5 file has these keys, too.
inline constexpr int kRunSchemaVersion = 2;

// Every key is always present. Empty texts: not known; `overrides` and `rest_s` are then null. Instruments'
// calibrations are completed with `notes` (instrument_calibration.h); a value that still says FILL-IN counts as not
// stated.
//   run uuid origin state outcome reason safe_state operator purpose sensor sensor_type_sha256 scanner bench
//   bench_sha256 overrides seed sensor_seed started_utc ended_utc rest_s host time_zone program_version git_commit
//   git_dirty build_id content_sha256 tags notes void void_reason void_by void_utc
//   recipes: name sha256 repeats frames_per_repeat, in the order of the run's sequences
//   devices: role model serial firmware origin certificate calibrated_by calibrated due overdue uncertainty remarks
nlohmann::ordered_json run_json(const db::RunRecord& run, std::span<const InstrumentNote> notes = {});

// serial type type_sha256 scanner note added_utc
nlohmann::ordered_json sensor_json(const db::SensorRecord& sensor);

// Metadata of a run as KEY=VALUE pairs: lot, order and others. They are those of its tags that contain "="; like all
// tags they are remarks and not part of its content (db/hash_chain.h).

std::map<std::string, std::string> metadata_of(const db::RunRecord& run);

}  // namespace tactbench::analysis
