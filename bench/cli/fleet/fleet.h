// The verbs of the fleet, one function for each file.
#pragma once

#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_fleet_push(CLI::App& fleet, Session& session);
void add_fleet_status(CLI::App& fleet, Session& session);
void add_fleet_readers(CLI::App& fleet, Session& session);  // runs, show, trend

// How a verb names the fleet: --to where it writes, --from where it reads; otherwise by TACTBENCH_FLEET or
// tactbench.toml.
void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session);

}  // namespace tactbench::bench
