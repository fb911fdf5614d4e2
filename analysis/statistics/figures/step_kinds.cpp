#include "analysis/statistics/figures/step_kinds.h"

#include <algorithm>

#include "analysis/loop.h"

namespace tactbench::analysis {
namespace {

constexpr double kFullBranchShare = 0.01;  // as external_loop

}  // namespace

std::vector<StepKind> step_kinds(const SequenceData& sequence, double low, double high) {
  if (sequence.repeats.empty()) return {};
  std::vector<double> commanded;
  for (const Sample& step : sequence.repeats.front().steps) commanded.push_back(step.setpoint_psi);
  std::vector<StepKind> kinds(commanded.size());
  const double near = kFullBranchShare * (high - low);
  int number = 0;
  for (const Branch& branch : branches_along(commanded)) {
    const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
    const auto [bottom, top] = std::minmax(commanded[first], commanded[last]);
    const bool full = bottom - low <= near && high - top <= near;
    for (std::size_t i = first == 0 ? first : first + 1; i <= last; ++i) kinds[i] = {full, branch.ascending, number};
    ++number;
  }
  return kinds;
}

}  // namespace tactbench::analysis
