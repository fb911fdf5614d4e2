// How each sequence of a run was carried out, in words: what its recipe, with the values that were set, says.
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::bench {

// In the order of the run's sequences: "levels every 4 psi, turning at 0, 60, 0 psi; dwell 1 s ...". Empty where the
// recipe cannot be read any more.
std::vector<std::string> method_words(const db::RunRecord& run);

}  // namespace tactbench::bench
