#include <algorithm>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/studies/studies.h"

namespace tactbench::analysis {
namespace {

constexpr double kMountLevelPsi = 0.05;  // levels this near are the same
constexpr double kLowestMountPsi = 0.5;
constexpr double kShareFrom = 0.1;  // of the highest level: shares of less say more of the zero than of the mount

std::size_t level_of(const SweepEstimates& estimates, double pressure) {
  const auto found = std::ranges::find_if(estimates.pressure_psi,
                                          [&](double level) { return std::abs(level - pressure) < kMountLevelPsi; });
  return static_cast<std::size_t>(found - estimates.pressure_psi.begin());
}

// One-way analysis of variance with groups of unequal size: variances within, and between beyond it.
struct TwoVariances {
  double within = kNan, between = kNan;
};
TwoVariances variances_of(const std::vector<std::vector<double>>& groups) {
  double all = 0.0, n = 0.0, n_squares = 0.0, squares_within = 0.0, squares_between = 0.0;
  for (const std::vector<double>& group : groups) {
    for (const double value : group) all += value;
    n += static_cast<double>(group.size());
    n_squares += static_cast<double>(group.size() * group.size());
  }
  all /= n;
  const auto k = static_cast<double>(groups.size());
  for (const std::vector<double>& group : groups) {
    const double mean = mean_of(group);
    squares_between += static_cast<double>(group.size()) * (mean - all) * (mean - all);
    for (const double value : group) squares_within += (value - mean) * (value - mean);
  }
  if (k < 2.0) return {};
  const double within = n > k ? squares_within / (n - k) : 0.0;
  const double size = (n - n_squares / n) / (k - 1.0);  // of a group, where they differ
  return {within, std::max(0.0, (squares_between / (k - 1.0) - within) / size)};
}

struct LevelOfMounts {
  double within_psi, between_psi, mean_between_psi;
  std::vector<double> taxel_between;  // variances
};

LevelOfMounts level_of_mounts(std::span<const MountedRun> mounts, double pressure) {
  const auto taxels = static_cast<std::size_t>(mounts.front().estimates.taxels);
  LevelOfMounts out{0.0, 0.0, 0.0, std::vector<double>(taxels, kNan)};
  std::vector<std::vector<double>> mean(mounts.size());
  for (std::size_t m = 0; m < mounts.size(); ++m)
    mean[m].assign(static_cast<std::size_t>(mounts[m].estimates.sweeps), 0.0);
  double count = 0.0;
  for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
    std::vector<std::vector<double>> groups(mounts.size());
    bool finite = true;
    for (std::size_t m = 0; m < mounts.size(); ++m) {
      const SweepEstimates& own = mounts[m].estimates;
      const std::size_t level = level_of(own, pressure);
      for (int sweep = 0; sweep < own.sweeps; ++sweep) {
        groups[m].push_back(own.at(level, sweep, static_cast<int>(taxel)));
        finite = finite && std::isfinite(groups[m].back());
      }
    }
    if (!finite) continue;
    const TwoVariances variances = variances_of(groups);
    out.within_psi += variances.within;
    out.between_psi += variances.between;
    out.taxel_between[taxel] = variances.between;
    for (std::size_t m = 0; m < mounts.size(); ++m)
      for (std::size_t sweep = 0; sweep < groups[m].size(); ++sweep) mean[m][sweep] += groups[m][sweep];
    count += 1.0;
  }
  out.within_psi = std::sqrt(out.within_psi / count);
  out.between_psi = std::sqrt(out.between_psi / count);
  out.mean_between_psi = std::sqrt(variances_of(mean).between) / count;
  return out;
}

}  // namespace

Remount remount_of(std::span<const MountedRun> mounts) {
  Remount remount;
  for (const MountedRun& mount : mounts) remount.runs.push_back(mount.run);
  if (mounts.size() < 2) return remount;
  for (const double level : mounts.front().estimates.pressure_psi) {
    const bool everywhere = std::ranges::all_of(mounts, [&](const MountedRun& mount) {
      return level_of(mount.estimates, level) < mount.estimates.pressure_psi.size();
    });
    if (everywhere && level > kLowestMountPsi) remount.pressure_psi.push_back(level);
  }
  if (remount.pressure_psi.empty()) {
    remount.not_assessed = "the mounts have no level in common";
    return remount;
  }
  const auto taxels = static_cast<std::size_t>(mounts.front().estimates.taxels);
  const auto levels = static_cast<double>(remount.pressure_psi.size());
  remount.taxel_between_psi.assign(taxels, 0.0);
  int counted = 0;
  for (const double pressure : remount.pressure_psi) {
    const LevelOfMounts level = level_of_mounts(mounts, pressure);
    remount.within_psi.push_back(level.within_psi);
    remount.between_psi.push_back(level.between_psi);
    remount.mean_between_psi.push_back(level.mean_between_psi);
    for (std::size_t taxel = 0; taxel < taxels; ++taxel)
      remount.taxel_between_psi[taxel] += level.taxel_between[taxel] / levels;
    if (pressure < kShareFrom * remount.pressure_psi.back()) continue;
    ++counted;
    remount.within_share += std::pow(level.within_psi / pressure, 2);
    remount.s_share += std::pow(level.between_psi / pressure, 2);
    const double common = std::min(level.mean_between_psi, level.between_psi) / pressure;
    remount.common_share += common * common;
  }
  for (double& value : remount.taxel_between_psi) value = std::sqrt(value);
  remount.within_share = std::sqrt(remount.within_share / counted);
  remount.s_share = std::sqrt(remount.s_share / counted);
  remount.common_share = std::sqrt(remount.common_share / counted);
  remount.own_share = std::sqrt(std::max(0.0, std::pow(remount.s_share, 2) - std::pow(remount.common_share, 2)));
  remount.degrees = static_cast<int>(mounts.size()) - 1;
  const auto fitted = std::ranges::count_if(remount.taxel_between_psi, [](double s) { return std::isfinite(s); });
  remount.own_degrees = remount.degrees * std::max(1, static_cast<int>(fitted) - 1);
  remount.not_assessed.clear();
  return remount;
}

}  // namespace tactbench::analysis
