// Decides which taxels of a run or table can be modelled, and which were: the only place that decides dead, stuck and
// saturated.
#pragma once

#include <string_view>

namespace tactbench::analysis {

// Of histories kFitted says: can be fitted.
enum class TaxelStatus { kFitted, kDead, kStuck, kSaturated, kUnfit, kConstant };
const char* to_string(TaxelStatus status);  // fitted, dead, stuck, saturated, unfit, constant
// False: `word` is none of these, `status` is as before.
[[nodiscard]] bool status_from(std::string_view word, TaxelStatus& status);

inline constexpr double kDeadV = 0.05;       // an output that spans less is dead (near 0 V) or stuck
inline constexpr double kUnfitShare = 0.10;  // a mean error above this share of the taxel's full scale is unfit

// Of one taxel's outputs as measured, before those of a falling sensor are negated: kSaturated (also one that is at
// the converter's limit for ever), kDead, kStuck, or kFitted. Dead: lowest and highest output are both nearer to 0 V
// than `dead_v`.
struct OutputRange {
  double low = 0.0, high = 0.0;
};
TaxelStatus status_of(OutputRange outputs, bool at_limit, double dead_v = kDeadV);

}  // namespace tactbench::analysis
