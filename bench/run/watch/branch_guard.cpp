#include "bench/run/watch/branch_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactbench::bench {

std::optional<std::string> BranchGuard::see(double value) {
  if (!std::isfinite(value)) return "a reading is not a number";
  highest_ = std::max(highest_.value_or(value), value);
  lowest_ = std::min(lowest_.value_or(value), value);
  if (to_ >= from_ && *highest_ - value > tolerance_) {
    return fmt::format("rose to {:.2f} and fell back to {:.2f} in the branch from {:g} to {:g} (tolerance {:g})",
                       *highest_, value, from_, to_, tolerance_);
  }
  if (to_ <= from_ && value - *lowest_ > tolerance_) {
    return fmt::format("fell to {:.2f} and rose again to {:.2f} in the branch from {:g} to {:g} (tolerance {:g})",
                       *lowest_, value, from_, to_, tolerance_);
  }
  return std::nullopt;
}

}  // namespace tactbench::bench
