#include "analysis/identify/elam/dispatch.h"

#include <array>
#include <cstddef>

namespace tactbench::analysis {

namespace {

std::size_t dispatches_here() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) return 1;
  // All instruction sets used by a version are checked; no known processor has only some of them.
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  return avx512 ? 3 : 2;
#else
  return 1;
#endif
}

}  // namespace

const char* to_string(Dispatch dispatch) {
  constexpr std::array kNames{"base", "avx2", "avx512"};
  return kNames[static_cast<std::size_t>(dispatch)];
}

std::span<const Dispatch> dispatches() {
  static constexpr std::array kAll{Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512};
  static const std::size_t count = dispatches_here();
  return std::span(kAll).first(count);
}

Dispatch best_dispatch() { return dispatches().back(); }

}  // namespace tactbench::analysis
