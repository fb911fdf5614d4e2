// Eight doubles side by side, in which the searches of identification look at eight candidates. Each lane does the same
// operations in the same order without fused multiply-adds, so that its result is the same bit for bit on every
// processor, however candidates are grouped.
#pragma once

#include <cstddef>

// A copy of a function for each class of processors, of which the best is chosen when the program is loaded; before
// ThreadSanitizer is ready. What it calls is inlined, so that no code of a higher class gets into a lower one. Clang 16
// does not emit templates that only such a copy uses: there one plain copy.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define TACTBENCH_CLONES __attribute__((target_clones("default", "avx2", "arch=x86-64-v4")))
#else
#define TACTBENCH_CLONES
#endif
#define TACTBENCH_INLINE inline __attribute__((always_inline))

namespace tactbench::analysis {

inline constexpr std::size_t kLanes = 8;
typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
typedef long long LaneMask __attribute__((vector_size(kLanes * sizeof(long long))));
typedef int LaneIndex __attribute__((vector_size(kLanes * sizeof(int))));

TACTBENCH_INLINE void load(Lanes& to, const double* from) { __builtin_memcpy(&to, from, sizeof(Lanes)); }
TACTBENCH_INLINE void store(double* to, const Lanes& from) { __builtin_memcpy(to, &from, sizeof(Lanes)); }

}  // namespace tactbench::analysis
