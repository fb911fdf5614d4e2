// The [simulation] table of a bench file: plant, seeds, effects, defects, wire faults.
#pragma once

#include "bench/config/config.h"

namespace tactbench::bench {

SimulationConfig read_simulation(const sequences::TomlTable& table, const BenchConfig& config,
                                 const SeedOptions& seeds);
void add_simulation_keys(std::vector<sequences::KeyFacts>& all);

}  // namespace tactbench::bench
