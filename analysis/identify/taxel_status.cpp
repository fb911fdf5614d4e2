#include "analysis/identify/taxel_status.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tactbench::analysis {
namespace {

// Order of TaxelStatus.
constexpr std::array<const char*, 6> kWords = {"fitted", "dead", "stuck", "saturated", "unfit", "constant"};

}  // namespace

const char* to_string(TaxelStatus status) { return kWords[static_cast<std::size_t>(status)]; }

bool status_from(std::string_view word, TaxelStatus& status) {
  const auto* const found = std::ranges::find(kWords, word);
  if (found == kWords.end()) return false;
  status = static_cast<TaxelStatus>(found - kWords.begin());
  return true;
}

TaxelStatus status_of(OutputRange outputs, bool at_limit, double dead_v) {
  if (at_limit) return TaxelStatus::kSaturated;
  if (outputs.high - outputs.low >= dead_v) return TaxelStatus::kFitted;
  return std::max(std::abs(outputs.low), std::abs(outputs.high)) < dead_v ? TaxelStatus::kDead : TaxelStatus::kStuck;
}

}  // namespace tactbench::analysis
