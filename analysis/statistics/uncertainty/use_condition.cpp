#include "analysis/statistics/uncertainty/use_condition.h"

#include <array>
#include <cmath>

namespace tactbench::analysis {

const char* name_of(UseCondition condition) {
  static constexpr std::array<const char*, kUseConditions> kNames = {
      "full sweeps",
      "reversals over the whole range after full pressure",
      "small reversals after full pressure",
      "held pressures",
      "at another dwell",
      "at another temperature",
      "mounted anew",
      "on another day"};
  return kNames[static_cast<std::size_t>(condition)];
}

ReadingUncertainty reading_uncertainty(const ConditionUncertainty& condition, std::size_t taxel, double reading_psi,
                                       bool up) {
  const std::size_t levels = condition.pressure_psi.size(), width = condition.taxels();
  std::size_t below = levels, above = levels;
  for (std::size_t i = 0; i < levels; ++i) {
    if (condition.up[i] != up) continue;
    if (condition.pressure_psi[i] <= reading_psi) below = i;
    if (above == levels && condition.pressure_psi[i] >= reading_psi) above = i;
  }
  if (below == levels && above == levels) return {kNan, kNan};
  if (below == levels) below = above;
  if (above == levels) above = below;
  const double span = condition.pressure_psi[above] - condition.pressure_psi[below];
  const double share = span > 0.0 ? (reading_psi - condition.pressure_psi[below]) / span : 0.0;
  const auto between = [&](const std::vector<double>& values) {
    return std::lerp(values[below * width + taxel], values[above * width + taxel], share);
  };
  return {between(condition.error_psi), between(condition.expanded_psi)};
}

std::optional<UseCondition> worst_of(std::span<const ConditionUncertainty> conditions) {
  const ConditionUncertainty* worst = nullptr;
  for (const ConditionUncertainty& each : conditions)
    if (each.valid() && static_cast<std::size_t>(each.condition) < kHistoryKinds &&
        (worst == nullptr || each.median_psi > worst->median_psi))
      worst = &each;
  return worst == nullptr ? std::nullopt : std::optional(worst->condition);
}

}  // namespace tactbench::analysis
