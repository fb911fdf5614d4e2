// The pressure side of the bench file: [module], [input_module], [regulator], [reference], [environment].
#pragma once

#include "bench/config/config.h"

namespace tactbench::bench {

// Needs origin and limits to be read already.
void read_pressure(const sequences::TomlTable& root, BenchConfig& config);
void add_pressure_keys(std::vector<sequences::KeyFacts>& all);

}  // namespace tactbench::bench
