// The pressure interval in which a reading is within a requested error.
#pragma once

#include "analysis/statistics/uncertainty/history_kind.h"

namespace tactbench::analysis {

inline constexpr double kMeasuringShare = 0.95;  // of the taxels

struct MeasuringInterval {
  bool any = false;  // false: at no level
  double low_psi = 0.0, high_psi = 0.0;
};

// The longest run of neighbouring levels of one direction at each of which |error| + U of at least `share` of the
// taxels is at most `mpe_psi`; of two as long the lower. `fitted`: taxels that count, those without U as above it.
// None where the condition is not valid, or no level of that direction was counted.
MeasuringInterval measuring_interval(const ConditionUncertainty& condition, bool up, double mpe_psi,
                                     std::span<const std::size_t> fitted, double share = kMeasuringShare);

}  // namespace tactbench::analysis
