// The verb selfcheck (bench/selfcheck has its checks).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_selfcheck(CLI::App& app, Session& session);

// A record of it as people read it.
std::string selfcheck_text(const nlohmann::ordered_json& record);

}  // namespace tactbench::bench
