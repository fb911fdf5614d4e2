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
// Equal in every copy of the store.
std::string said_sha256(const db::RunStore& store, const db::RunRecord& run);
// The facts: run_json() with frames, sensor_type, verdict (the current one), fits, verdicts (each with the UUID of its
// models' run and the fit's position among that run's), figures, reports, rests_on: the UUIDs of the runs on which its
// models and verdicts are based. Without zero bytes in texts, which jsonb cannot store.
std::string facts_of(const db::RunStore& store, const db::RunRecord& run);

struct LocalRun {
  db::RunRecord run;
  std::string said_sha256;
  bool content = true;  // for a run to be pushed: the run itself; false: only what was recorded about it later
};
// Ended runs by number; without those whose frames were removed, since the fleet keeps whole runs.
std::vector<LocalRun> ended_runs(const db::RunStore& store);
// Those of `runs` that the server does not have in their present state. A state that any store has already pushed is
// sent again only if it differs from the last one from this store (`source`), so that an old copy of a store reverts
// nothing.
std::vector<LocalRun> waiting_runs(db::fleet::Link& link, const std::vector<LocalRun>& runs, const std::string& source);

// "host:/path/runs.db": the store, as the fleet knows it.
std::string source_name(const std::string& store);

// The models on which the verdicts of a run are based, from its facts. Throws nlohmann::json::exception if they are
// malformed.
using ModelsOfVerdicts = std::vector<std::pair<std::string, std::size_t>>;  // UUID of the run, position of the fit
ModelsOfVerdicts models_of_verdicts(const nlohmann::json& facts);
// Links the verdicts of a run to the fits of other runs of `store`, as far as these are there.
void link_verdicts(db::RunStore& store, std::int64_t run, const ModelsOfVerdicts& models);

}  // namespace tactbench::bench
