#include "analysis/identify/rivals/gpi_lanes.h"

#include <cmath>

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
  for (std::size_t lane = 0; lane < kMost; ++lane) {
    const GpiPoint& p = at[lane];
    const auto shape = [&](Shape& own, GpiUnknown ln_a, GpiUnknown start, GpiUnknown ln_rise) {
      own.a[lane] = std::exp(p[ln_a]);
      own.start[lane] = p[start];
      own.rise[lane] = std::exp(p[ln_rise]);
      own.end[lane] = std::exp(-own.a[lane]);
      own.per_whole[lane] = -1.0 / std::expm1(-own.a[lane]);
    };
    shape(left, kLnA, kL0, kLnDl);
    shape(right, kLnB, kR0, kLnDr);
    const double alpha = std::exp(p[kLnAlpha]), fall = std::exp(-p[kS]);
    double share = 1.0;
    for (std::size_t i = 0; i < kGpiOperators; ++i, share *= fall) {
      threshold[i][lane] = alpha * static_cast<double>(i);
      density[i][lane] = share;
    }
  }
  kGpiLevels[static_cast<std::size_t>(lane_dispatch())](*this, target, gradient);
}

}  // namespace tactbench::analysis
