// The subcommands of `fleet`, one function per source file.
#pragma once

#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_fleet_push(CLI::App& fleet, Session& session);
void add_fleet_status(CLI::App& fleet, Session& session);
void add_fleet_readers(CLI::App& fleet, Session& session);  // runs, show, trend

// Option that names the fleet: --to where a verb writes, --from where it reads; otherwise TACTBENCH_FLEET or
// tactbench.toml.
void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session);

}  // namespace tactbench::bench
