// The verbs of the fleet, one function for each file.
#pragma once

#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_fleet_push(CLI::App& fleet, Session& session);
void add_fleet_status(CLI::App& fleet, Session& session);
void add_fleet_readers(CLI::App& fleet, Session& session);  // runs, show, trend
void add_fleet_fit(CLI::App& fleet, Session& session);

// How a verb names the fleet: --to where it writes, --from where it reads; otherwise by TACTBENCH_FLEET or
// tactbench.toml.
void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session);

// Which origin a verb of the fleet looks at; they never mix.
void add_origin(CLI::App& verb, std::string& origin);

// "host:/path/runs.db": the store, as the fleet knows it.
std::string source_name(const std::string& store);

void add_fleet_slurm(CLI::App& fleet, Session& session);

}  // namespace tactbench::bench
