#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "analysis/compensate/dynamic_lanes.h"
#include "analysis/compensate/frame_compensator.h"

// The same operations in the same order on each level, none contracted: the same bits. Elsewhere than on x86-64 all
// levels are alike.
#if defined(__x86_64__)
#define TACTBENCH_VECTORS(words) __attribute__((target(words)))
#else
#define TACTBENCH_VECTORS(words)
#endif

#define TACTBENCH_PASS_LEVEL base
#define TACTBENCH_PASS_TURN turn_base
#define TACTBENCH_PASS_LOCATE locate_base
#define TACTBENCH_PASS_FINISH finish_base
#define TACTBENCH_PASS_TARGET
#include "analysis/compensate/dynamic_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_TURN
#undef TACTBENCH_PASS_LOCATE
#undef TACTBENCH_PASS_FINISH
#undef TACTBENCH_PASS_TARGET

#define TACTBENCH_PASS_LEVEL avx2
#define TACTBENCH_PASS_TURN turn_avx2
#define TACTBENCH_PASS_LOCATE locate_avx2
#define TACTBENCH_PASS_FINISH finish_avx2
#define TACTBENCH_PASS_TARGET TACTBENCH_VECTORS("avx2")
#include "analysis/compensate/dynamic_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_TURN
#undef TACTBENCH_PASS_LOCATE
#undef TACTBENCH_PASS_FINISH
#undef TACTBENCH_PASS_TARGET

#define TACTBENCH_PASS_LEVEL avx512
#define TACTBENCH_PASS_TURN turn_avx512
#define TACTBENCH_PASS_LOCATE locate_avx512
#define TACTBENCH_PASS_FINISH finish_avx512
#define TACTBENCH_PASS_TARGET TACTBENCH_VECTORS("avx512f,avx512dq,avx512bw,avx512vl")
#include "analysis/compensate/dynamic_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_TURN
#undef TACTBENCH_PASS_LOCATE
#undef TACTBENCH_PASS_FINISH
#undef TACTBENCH_PASS_TARGET

namespace tactbench::analysis {

template struct DynamicPasses<float>;
template struct DynamicPasses<double>;

}  // namespace tactbench::analysis
