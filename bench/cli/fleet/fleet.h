// Shared by the verbs of `fleet`.
#pragma once

#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

// Option that names the fleet: --to where a verb writes, --from where it reads; otherwise TACTBENCH_FLEET or
// tactbench.toml.
void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session);

}  // namespace tactbench::bench
