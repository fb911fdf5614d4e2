// The verb selfcheck (bench/selfcheck has its checks).
#pragma once

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_selfcheck(CLI::App& app, Session& session);

}  // namespace tactbench::bench
