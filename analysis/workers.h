// Distributes independent pieces of work over threads; the result of each piece does not depend on their number.
#pragma once

#include <cstddef>
#include <functional>

namespace tactbench::analysis {

// Calls work(0..count-1), each once, on `threads` threads (0: as many as there are cores). Rethrows the exception of
// the lowest index that failed, after all threads have ended.
void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace tactbench::analysis
