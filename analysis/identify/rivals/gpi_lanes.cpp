#include "analysis/identify/rivals/gpi_lanes.h"

#include "analysis/identify/elam/lanes.h"

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#include "analysis/identify/rivals/gpi_kernel.h"

namespace tactbench::analysis {
namespace {

template <int N>
TACTBENCH_INLINE void gpi_lanes(GpiLanes& lanes, const GpiTree::Target& target, bool gradient) {
  for (std::size_t lane = 0; lane < GpiLanes::kMost; lane += N) {
    if (gradient)
      kernel::gpi_walk<N, true>(lanes, target, lane);
    else
      kernel::gpi_walk<N, false>(lanes, target, lane);
  }
}

using GpiLevel = void (*)(GpiLanes&, const GpiTree::Target&, bool);
void gpi_base(GpiLanes& lanes, const GpiTree::Target& target, bool gradient) { gpi_lanes<2>(lanes, target, gradient); }
#if defined(__x86_64__)
__attribute__((target("avx2"))) void gpi_avx2(GpiLanes& lanes, const GpiTree::Target& target, bool gradient) {
  gpi_lanes<4>(lanes, target, gradient);
}
__attribute__((target("avx512f,avx512dq,avx512vl"))) void gpi_avx512(GpiLanes& lanes, const GpiTree::Target& target,
                                                                     bool gradient) {
  gpi_lanes<8>(lanes, target, gradient);
}
constexpr std::array<GpiLevel, 3> kGpiLevels{gpi_base, gpi_avx2, gpi_avx512};
#else
constexpr std::array<GpiLevel, 3> kGpiLevels{gpi_base, gpi_base, gpi_base};
#endif

}  // namespace
#pragma GCC diagnostic pop

GpiLanes::GpiLanes(const GpiTree& own) : tree(&own) {
  envelopes.resize(own.knots.size() * kernel::kFields * kMost);
  slots.resize(static_cast<std::size_t>(own.slots) * kGpiOperators * (1 + kernel::kFields) * kMost);
}

void GpiLanes::evaluate(const GpiTree::Target& target, bool gradient) {
  for (std::size_t lane = 0; lane < kMost; ++lane)
    for (std::size_t k = 0; k < kGpiUnknowns; ++k) unknown[k][lane] = at[lane][k];
  kGpiLevels[static_cast<std::size_t>(lane_dispatch())](*this, target, gradient);
}

}  // namespace tactbench::analysis
