#include "analysis/identify/lanes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#include "analysis/identify/lanes_kernel.h"

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

template <int N>
TACTBENCH_INLINE void ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  const bool uniform = lanes.problem->table.uniform();
  if (uniform && gradient == Gradient::kNone) kernel::ascending<N, true, Gradient::kNone>(lanes, count);
  if (uniform && gradient == Gradient::kPlane) kernel::ascending<N, true, Gradient::kPlane>(lanes, count);
  if (uniform && gradient == Gradient::kSpace) kernel::ascending<N, true, Gradient::kSpace>(lanes, count);
  if (!uniform && gradient == Gradient::kNone) kernel::ascending<N, false, Gradient::kNone>(lanes, count);
  if (!uniform && gradient == Gradient::kPlane) kernel::ascending<N, false, Gradient::kPlane>(lanes, count);
  if (!uniform && gradient == Gradient::kSpace) kernel::ascending<N, false, Gradient::kSpace>(lanes, count);
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

constexpr std::array kLevels{LaneLevel::kBase, LaneLevel::kAvx2, LaneLevel::kAvx512};

std::size_t levels_here() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) return 1;
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
             ? 3
             : 2;
#else
  return 1;
#endif
}

LaneLevel chosen() {
  const char* name = std::getenv("TACTBENCH_LANES");  // read once, before any thread of ours
  for (const LaneLevel level : lane_levels())
    if (name != nullptr && std::string(name) == to_string(level)) return level;
  return lane_levels().back();
}

std::atomic<int> forced{-1};

}  // namespace
#pragma GCC diagnostic pop

const char* to_string(LaneLevel level) {
  constexpr std::array kLevelNames{"base", "avx2", "avx512"};
  return kLevelNames[static_cast<std::size_t>(level)];
}

std::span<const LaneLevel> lane_levels() {
  static const std::size_t count = levels_here();
  return std::span(kLevels).first(count);
}

LaneLevel lane_level() {
  const int level = forced.load(std::memory_order_relaxed);
  if (level >= 0) return static_cast<LaneLevel>(level);
  static const LaneLevel own = chosen();
  return own;
}

void force_lane_level(LaneLevel level) {
  if (std::ranges::find(lane_levels(), level) == lane_levels().end())
    throw std::invalid_argument(std::string("this machine does not have the lanes of ") + to_string(level));
  forced = static_cast<int>(level);
}

void unforce_lane_level() { forced = -1; }

void lane_descending(const LaneProblem& problem, std::span<const double> alpha, std::span<double> j,
                     std::span<double> beta) {
  kDescending[static_cast<std::size_t>(lane_level())](problem, alpha.data(), alpha.size(), j.data(), beta.data());
}

void lane_ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  kAscending[static_cast<std::size_t>(lane_level())](lanes, (count + 7) / 8 * 8, gradient);
}

}  // namespace tactbench::analysis
