// Builds the facts that the fleet database stores next to a packed run, as JSON for queries; compares a store with the
// fleet; and, after import, links verdicts to the fits of other imported runs.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "db/fleet/runs.h"
#include "db/run_store.h"

namespace tactbench::bench {

// Hash of the run's content and of everything recorded about it: tags, notes, void, fits, verdicts, figures, reports.
// The same in each copy of the store.
std::string said_sha256(const db::RunStore& store, const db::RunRecord& run);
// The facts: run_json() with frames, sensor_type, verdict (the standing one), fits, verdicts (each with the UUID of its
// models' run and the fit's position among that run's), figures, reports, rests_on: the UUIDs of the runs that its
// models and verdicts rest on. Without zero bytes in texts, which jsonb does not keep.
std::string facts_of(const db::RunStore& store, const db::RunRecord& run);

struct LocalRun {
  db::RunRecord run;
  std::string said_sha256;
  bool content = true;  // of one that waits: the run itself; false: only what was said of it later
};
// Ended runs by number; without those whose frames were removed, since the fleet keeps whole runs.
std::vector<LocalRun> ended_runs(const db::RunStore& store);
// Those of `runs` that the server does not have in their present state. A state that some store has pushed already is
// sent again only when it is a change to the last one from this store (`source`): an old copy of a store reverts
// nothing.
std::vector<LocalRun> waiting_runs(db::fleet::Link& link, const std::vector<LocalRun>& runs, const std::string& source);

// "host:/path/runs.db": the store, as the fleet knows it.
std::string source_name(const std::string& store);

// The models by which the verdicts of a run were made, from its facts. Throws nlohmann::json::exception where they are
// malformed.
using ModelsOfVerdicts = std::vector<std::pair<std::string, std::size_t>>;  // UUID of the run, position of the fit
ModelsOfVerdicts models_of_verdicts(const nlohmann::json& facts);
// Links the verdicts of a run to the fits of other runs of `store`, as far as these are there.
void link_verdicts(db::RunStore& store, std::int64_t run, const ModelsOfVerdicts& models);

}  // namespace tactbench::bench
