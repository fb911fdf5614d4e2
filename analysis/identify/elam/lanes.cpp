#include "analysis/identify/elam/lanes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#include "analysis/identify/elam/lanes_kernel.h"

namespace tactbench::analysis {
namespace {

using Descending = void (*)(const LaneProblem&, const double*, std::size_t, double*, double*);
using Ascending = void (*)(AscendingLanes&, std::size_t, Gradient);

template <int N>
TACTBENCH_INLINE void descending(const LaneProblem& p, const double* alpha, std::size_t count, double* j,
                                 double* beta) {
  if (p.table.uniform())
    kernel::descending<N, true>(p, alpha, count, j, beta);
  else
    kernel::descending<N, false>(p, alpha, count, j, beta);
}

template <int N, bool kUniform>
TACTBENCH_INLINE void ascending_on(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  switch (gradient) {
    case Gradient::kNone:
      return kernel::ascending<N, kUniform, Gradient::kNone>(lanes, count);
    case Gradient::kPlane:
      return kernel::ascending<N, kUniform, Gradient::kPlane>(lanes, count);
    case Gradient::kSpace:
      return kernel::ascending<N, kUniform, Gradient::kSpace>(lanes, count);
  }
}

template <int N>
TACTBENCH_INLINE void ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  if (lanes.problem->table.uniform())
    ascending_on<N, true>(lanes, count, gradient);
  else
    ascending_on<N, false>(lanes, count, gradient);
}

// An attribute and names cannot stand in parentheses. NOLINTBEGIN(bugprone-macro-parentheses)
#define TACTBENCH_LEVEL(name, lanes_of_level, target)                                                    \
  target void descending_##name(const LaneProblem& p, const double* alpha, std::size_t count, double* j, \
                                double* beta) {                                                          \
    descending<lanes_of_level>(p, alpha, count, j, beta);                                                \
  }                                                                                                      \
  target void ascending_##name(AscendingLanes& lanes, std::size_t count, Gradient gradient) {            \
    ascending<lanes_of_level>(lanes, count, gradient);                                                   \
  }
// NOLINTEND(bugprone-macro-parentheses)

TACTBENCH_LEVEL(base, 2, )
#if defined(__x86_64__)
TACTBENCH_LEVEL(avx2, 4, __attribute__((target("avx2"))))
TACTBENCH_LEVEL(avx512, 8, __attribute__((target("avx512f,avx512dq,avx512vl"))))
constexpr std::array<Descending, 3> kDescending{descending_base, descending_avx2, descending_avx512};
constexpr std::array<Ascending, 3> kAscending{ascending_base, ascending_avx2, ascending_avx512};
#else
constexpr std::array<Descending, 3> kDescending{descending_base, descending_base, descending_base};
constexpr std::array<Ascending, 3> kAscending{ascending_base, ascending_base, ascending_base};
#endif
#undef TACTBENCH_LEVEL

Dispatch chosen() {
  const char* name = std::getenv("TACTBENCH_LANES");  // read once, before any thread of ours
  for (const Dispatch dispatch : dispatches())
    if (name != nullptr && std::string(name) == to_string(dispatch)) return dispatch;
  return best_dispatch();
}

std::atomic<int> forced{-1};

}  // namespace
#pragma GCC diagnostic pop

Dispatch lane_dispatch() {
  const int dispatch = forced.load(std::memory_order_relaxed);
  if (dispatch >= 0) return static_cast<Dispatch>(dispatch);
  static const Dispatch own = chosen();
  return own;
}

void force_lane_dispatch(Dispatch dispatch) {
  if (std::ranges::find(dispatches(), dispatch) == dispatches().end())
    throw std::invalid_argument(std::string("this processor does not have the lanes of ") + to_string(dispatch));
  forced = static_cast<int>(dispatch);
}

void unforce_lane_dispatch() { forced = -1; }

void lane_descending(const LaneProblem& problem, std::span<const double> alpha, std::span<double> j,
                     std::span<double> beta) {
  kDescending[static_cast<std::size_t>(lane_dispatch())](problem, alpha.data(), alpha.size(), j.data(), beta.data());
}

void lane_ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  kAscending[static_cast<std::size_t>(lane_dispatch())](lanes, (count + 7) / 8 * 8, gradient);
}

}  // namespace tactbench::analysis
