// The bench file's other instruments: [scanner], [stage], [force].
#pragma once

#include "bench/config/config.h"

namespace tactbench::bench {

// Needs the origin to be read already.
void read_instruments(const sequences::TomlTable& root, BenchConfig& config);
void add_instrument_keys(std::vector<sequences::KeyFacts>& all);

}  // namespace tactbench::bench
