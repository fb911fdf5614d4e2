// Selects the vector level of code that exists in several versions: frames of the compensator, lanes of identification.
// Results are bit-identical at every level.
#pragma once

#include <span>

namespace tactbench::analysis {

enum class Dispatch { kBase, kAvx2, kAvx512 };  // vectors of 16, 32, 64 bytes

const char* to_string(Dispatch dispatch);  // base, avx2, avx512
std::span<const Dispatch> dispatches();    // that this processor has, lowest first; kBase always
[[nodiscard]] Dispatch best_dispatch();    // the last of them

}  // namespace tactbench::analysis
