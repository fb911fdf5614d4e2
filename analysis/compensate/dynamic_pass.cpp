#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "analysis/compensate/dynamic_lanes.h"
#include "analysis/compensate/frame_compensator.h"

// The same operations in the same order on each level, none contracted: the same bits.

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

#if defined(__x86_64__)
#define TACTBENCH_PASS_LEVEL avx2
#define TACTBENCH_PASS_TURN turn_avx2
#define TACTBENCH_PASS_LOCATE locate_avx2
#define TACTBENCH_PASS_FINISH finish_avx2
#define TACTBENCH_PASS_TARGET __attribute__((target("avx2")))
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
#define TACTBENCH_PASS_TARGET __attribute__((target("avx512f,avx512dq,avx512bw,avx512vl")))
#include "analysis/compensate/dynamic_pass_level.h"
#undef TACTBENCH_PASS_LEVEL
#undef TACTBENCH_PASS_TURN
#undef TACTBENCH_PASS_LOCATE
#undef TACTBENCH_PASS_FINISH
#undef TACTBENCH_PASS_TARGET
#endif

namespace tactbench::analysis {

#if !defined(__x86_64__)
template <class Real>
unsigned DynamicPasses<Real>::avx2(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f,
                                   Real* outputs, Mark* marks) {
  return base(b, samples, f, outputs, marks);
}
template <class Real>
void DynamicPasses<Real>::locate_avx2(DynamicBlock<Real>& b, const DynamicSearch<Real>& s,
                                      const DynamicTables<Real>& t) {
  locate_base(b, s, t);
}
template <class Real>
unsigned DynamicPasses<Real>::avx512(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f,
                                     Real* outputs, Mark* marks) {
  return base(b, samples, f, outputs, marks);
}
template <class Real>
void DynamicPasses<Real>::locate_avx512(DynamicBlock<Real>& b, const DynamicSearch<Real>& s,
                                        const DynamicTables<Real>& t) {
  locate_base(b, s, t);
}
template <class Real>
void DynamicPasses<Real>::finish_avx2(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                                      const FrameResults<Real>& results) {
  finish_base(b, f, outputs, results);
}
template <class Real>
void DynamicPasses<Real>::finish_avx512(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                                        const FrameResults<Real>& results) {
  finish_base(b, f, outputs, results);
}
#endif

template struct DynamicPasses<float>;
template struct DynamicPasses<double>;

}  // namespace tactbench::analysis
