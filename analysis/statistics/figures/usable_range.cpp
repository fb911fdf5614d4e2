#include "analysis/statistics/figures/usable_range.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

double moved_by(const PatternCurve& curve, double x, double step) {
  const double y = curve(x), at = curve.inverse(y);
  return std::max(std::abs(curve.inverse(y + step) - at), std::abs(curve.inverse(y - step) - at));
}

// The longest row of levels whose share is large enough.
std::pair<double, double> longest_row(const std::vector<double>& levels, const std::vector<double>& shares,
                                      double least) {
  std::size_t best = 0, best_first = 0, first = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (shares[i] < least) {
      first = i + 1;
      continue;
    }
    if (i + 1 - first > best) {
      best = i + 1 - first;
      best_first = first;
    }
  }
  if (best == 0) return {kNan, kNan};
  return {levels[best_first], levels[best_first + best - 1]};
}

UsableBranch branch_of_patterns(const SensorModel& fit, PatternCurve ModelTaxel::*pattern,
                                const UsableOptions& options) {
  UsableBranch branch;
  for (const double level : fit.pressure_psi) {
    int resolved = 0;
    std::vector<double> moves;
    for (const ModelTaxel& taxel : fit.array()) {
      if (taxel.status != TaxelStatus::kFitted) continue;
      const PatternCurve& curve = taxel.*pattern;
      const double noise = options.in_noises * taxel.noise;
      resolved += moved_by(curve, level, noise) <= options.most_psi ? 1 : 0;
      moves.push_back(moved_by(curve, level, std::hypot(noise, taxel.fit.mean_error)));
    }
    const auto count = static_cast<double>(moves.size());
    const auto usable = std::ranges::count_if(moves, [&](double move) { return move <= options.most_psi; });
    branch.resolved_share.push_back(moves.empty() ? kNan : resolved / count);
    branch.usable_share.push_back(moves.empty() ? kNan : static_cast<double>(usable) / count);
    std::ranges::sort(moves);
    branch.median_psi.push_back(moves.empty() ? kNan : moves[(moves.size() - 1) / 2]);
    branch.worst_psi.push_back(moves.empty() ? kNan : moves.back());
  }
  std::tie(branch.low_psi, branch.high_psi) = longest_row(fit.pressure_psi, branch.usable_share, options.least_share);
  std::tie(branch.resolved_low_psi, branch.resolved_high_psi) =
      longest_row(fit.pressure_psi, branch.resolved_share, options.least_share);
  return branch;
}

}  // namespace

UsableRange usable_range(const SensorModel& fit, const UsableOptions& options) {
  UsableRange range{options, fit.pressure_psi, branch_of_patterns(fit, &ModelTaxel::ascending, options),
                    branch_of_patterns(fit, &ModelTaxel::descending, options), 0};
  for (const ModelTaxel& taxel : fit.array()) range.taxels += taxel.status == TaxelStatus::kFitted ? 1 : 0;
  return range;
}

}  // namespace tactbench::analysis
