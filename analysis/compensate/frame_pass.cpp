#include <cmath>
#include <cstdint>
#include <type_traits>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "analysis/compensate/frame_compensator.h"
#include "analysis/compensate/frame_lanes.h"

namespace tactbench::analysis {
namespace {
// As wide as Real: what a comparison of vectors gives.
template <class Real>
using Whole = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
}  // namespace
}  // namespace tactbench::analysis

// One source for vectors of 16, 32 and 64 bytes. They stay inside the pass (all is inlined into it), hence the ABI of
// wide vectors does not matter. No contraction to fused multiply-add: the same bits on each.

#define TACTBENCH_PASS_LEVEL base
#define TACTBENCH_PASS_BYTES 16
#define TACTBENCH_PASS_TARGET
#include "analysis/compensate/frame_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_BYTES
#undef TACTBENCH_PASS_TARGET

#if defined(__x86_64__)
#define TACTBENCH_PASS_LEVEL avx2
#define TACTBENCH_PASS_BYTES 32
#define TACTBENCH_PASS_TARGET __attribute__((target("avx2")))
#include "analysis/compensate/frame_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_BYTES
#undef TACTBENCH_PASS_TARGET

#define TACTBENCH_PASS_LEVEL avx512
#define TACTBENCH_PASS_BYTES 64
#define TACTBENCH_PASS_TARGET __attribute__((target("avx512f,avx512dq,avx512bw,avx512vl")))
#include "analysis/compensate/frame_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_BYTES
#undef TACTBENCH_PASS_TARGET
#endif

namespace tactbench::analysis {

#if !defined(__x86_64__)
template <class Real, class Sample>
void FramePasses<Real, Sample>::avx2(FrameLanes<Real>& lanes, const Sample* samples,
                                     const FrameResults<Real>& results) {
  base(lanes, samples, results);
}
template <class Real, class Sample>
void FramePasses<Real, Sample>::avx512(FrameLanes<Real>& lanes, const Sample* samples,
                                       const FrameResults<Real>& results) {
  base(lanes, samples, results);
}
#endif

template struct FramePasses<float, std::uint16_t>;
template struct FramePasses<double, std::uint16_t>;
template struct FramePasses<float, float>;
template struct FramePasses<double, double>;

}  // namespace tactbench::analysis
