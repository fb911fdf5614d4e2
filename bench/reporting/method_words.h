// Describes how each sequence of a run was measured, from its recipe and the overridden values.
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::bench {

// In the order of the run's sequences: "3 repeats of 2 sweeps; a level every 4 psi, from 0 to 60 to 0 psi; waiting time
// (dwell) 1 s ...". Pressures in psi and kPa. Empty where the recipe cannot be read
// any more.
std::vector<std::string> method_words(const db::RunRecord& run);

}  // namespace tactbench::bench
