#include "analysis/identify/dynamic/dynamics_search.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/algebra/dense.h"
#include "analysis/compensate/compensator.h"
#include "analysis/identify/dynamic/track.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kHeldPsi = 0.5;  // a level is held while the reference stays within this of its first sample
constexpr std::size_t kHeldSamples = 10;
constexpr double kLagSettles = 6.0;  // seconds of a hold that the lag may still be in

std::vector<double> mean_above_zero(const Track& track, const std::vector<double>& zero_v,
                                    const std::vector<bool>& usable) {
  std::vector<double> mean;
  for (const double* const row : track.volts) {
    double sum = 0.0, count = 0.0;
    for (std::size_t t = 0; t < zero_v.size(); ++t)
      if (usable[t]) {
        sum += row[t] - zero_v[t];
        count += 1.0;
      }
    mean.push_back(sum / count);
  }
  return mean;
}

struct Hold {
  std::size_t first, last;  // settled samples
};

std::vector<Hold> holds_of(const Track& track) {
  std::vector<Hold> holds;
  for (std::size_t i = 0; i < track.time.size();) {
    std::size_t end = i + 1;
    while (end < track.time.size() && std::abs(track.pressure[end] - track.pressure[i]) < kHeldPsi) ++end;
    std::size_t first = i;
    while (first < end && track.time[first] < track.time[i] + kLagSettles) ++first;
    if (end >= first + kHeldSamples && track.pressure[i] > kHeldPsi) holds.push_back({first, end - 1});
    i = end;
  }
  return holds;
}

struct CreepRows {
  Eigen::MatrixXd columns;  // a row a sample: psi less the hold's mean, times the hold's mean output
  Eigen::VectorXd scale;    // that mean output
};

CreepRows creep_rows(const Track& track, const std::vector<Hold>& holds, const Dynamics& d) {
  const auto psi = walk_creep(track, d);
  Eigen::Index count = 0;
  for (const Hold& hold : holds) count += static_cast<Eigen::Index>(hold.last - hold.first + 1);
  CreepRows rows{Eigen::MatrixXd(count, kCreepElements), {}};
  Eigen::Index row = 0;
  for (const Hold& hold : holds)
    for (std::size_t j = 0; j < kCreepElements; ++j) {
      double mean = 0.0;
      const auto length = hold.last - hold.first + 1;
      for (std::size_t i = hold.first; i <= hold.last; ++i) mean += psi[i][j] / static_cast<double>(length);
      for (std::size_t i = hold.first; i <= hold.last; ++i)
        rows.columns(row + static_cast<Eigen::Index>(i - hold.first), static_cast<Eigen::Index>(j)) = psi[i][j] - mean;
      if (j + 1 == kCreepElements) row += static_cast<Eigen::Index>(length);
    }
  return rows;
}

// Outputs less the hold's mean, and that mean, row by row.
void relative(const std::vector<Hold>& holds, const std::vector<double>& above, Eigen::VectorXd& off,
              Eigen::VectorXd& mean_of) {
  Eigen::Index row = 0;
  for (const Hold& hold : holds) {
    double mean = 0.0;
    for (std::size_t i = hold.first; i <= hold.last; ++i)
      mean += above[i] / static_cast<double>(hold.last - hold.first + 1);
    for (std::size_t i = hold.first; i <= hold.last; ++i, ++row) {
      off[row] = above[i] - mean;
      mean_of[row] = mean;
    }
  }
}

// The mean output of a hold is the static one times its mean factor.
double mean_factor(const Track& track, const std::vector<Hold>& holds, const Dynamics& d) {
  const auto psi = walk_creep(track, d);
  double factor = 0.0, count = 0.0;
  for (const Hold& hold : holds)
    for (std::size_t i = hold.first; i <= hold.last; ++i) {
      double sum = 1.0;
      for (std::size_t j = 0; j < kCreepElements; ++j) sum += d.creep_share[j] * (psi[i][j] - 1.0);
      factor += sum;
      count += 1.0;
    }
  return factor / count;
}

// Each taxel's creep over the median taxel's; `shape`: a row a sample, the array's relative change within its hold.
void find_scales(const Track& track, const std::vector<Hold>& holds, const Eigen::VectorXd& shape,
                 const std::vector<double>& zero_v, const std::vector<bool>& usable, ArrayDynamics& result) {
  const std::array<double, kCreepElements>& share = result.shared.creep_share;
  const double total = share[0] + share[1] + share[2];
  const double most = total > 0.0 ? std::min(kMostCreepScale, kMostCreep / total) : kMostCreepScale;
  Eigen::VectorXd off(shape.size()), level(shape.size());
  struct Scale {
    std::size_t taxel;
    double scale, doubt2;
  };
  std::vector<Scale> scales;
  for (std::size_t t = 0; t < zero_v.size(); ++t) {
    if (!usable[t]) continue;
    std::vector<double> above;
    for (const double* const row : track.volts) above.push_back(row[t] - zero_v[t]);
    relative(holds, above, off, level);
    const Eigen::VectorXd column = level.cwiseProduct(shape);
    if (column.squaredNorm() <= 0.0) continue;
    const double scale = column.dot(off) / column.squaredNorm();
    scales.push_back(
        {t, scale, (off - scale * column).squaredNorm() / static_cast<double>(off.size()) / column.squaredNorm()});
  }
  std::vector<double> all;
  for (const Scale& own : scales) all.push_back(own.scale);
  const double median = median_of(all);
  if (!(median > 0.0)) return;
  for (const Scale& own : scales) {
    constexpr double kSpread2 = 0.25 * 0.25;  // of taxels, as far as is known before
    const double scale = own.scale / median, doubt2 = own.doubt2 / (median * median);
    result.creep_scale[own.taxel] = std::clamp(1.0 + (scale - 1.0) * kSpread2 / (kSpread2 + doubt2), 0.0, most);
  }
}

}  // namespace

void find_creep(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                ArrayDynamics& result) {
  const Track track = track_of(data);
  const std::vector<Hold> holds = holds_of(track);
  result.holds = static_cast<int>(holds.size());
  if (holds.empty()) return;
  const std::vector<double> mean = mean_above_zero(track, zero_v, usable);
  double least = std::numeric_limits<double>::infinity();
  Eigen::VectorXd off, level;
  Eigen::MatrixXd best_columns;
  Eigen::VectorXd share_found = Eigen::VectorXd::Zero(kCreepElements);
  for (double half = 1.0; half <= 64.0; half *= 1.2) {
    Dynamics d = result.shared;
    d.creep_half = half;
    const CreepRows rows = creep_rows(track, holds, d);
    off.resize(rows.columns.rows());
    level.resize(rows.columns.rows());
    relative(holds, mean, off, level);
    const Eigen::MatrixXd columns = level.asDiagonal() * rows.columns;
    const Eigen::VectorXd share = non_negative_least_squares(gram_of(columns), columns.transpose() * off);
    const double rest = (off - columns * share).squaredNorm();
    if (rest >= least) continue;
    least = rest;
    best_columns = rows.columns;
    share_found = share;
    result.shared.creep_half = half;
    for (std::size_t j = 0; j < kCreepElements; ++j) result.shared.creep_share[j] = share[static_cast<Eigen::Index>(j)];
  }
  const double factor = mean_factor(track, holds, result.shared);
  for (double& k : result.shared.creep_share) k *= factor;
  find_scales(track, holds, best_columns * share_found, zero_v, usable, result);
}

void find_creep_scales(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                       ArrayDynamics& result) {
  const Track track = track_of(data);
  const std::vector<Hold> holds = holds_of(track);
  if (holds.empty()) return;
  const Eigen::Map<const Eigen::Vector3d> share(result.shared.creep_share.data());
  const Eigen::VectorXd shape = creep_rows(track, holds, result.shared).columns * share;
  find_scales(track, holds, shape / mean_factor(track, holds, result.shared), zero_v, usable, result);
}

ArrayDynamics find_dynamics(const Dataset* rate, const Dataset* creep, const std::vector<double>& zero_v,
                            const std::vector<bool>& usable) {
  ArrayDynamics result;
  result.creep_scale.assign(zero_v.size(), 1.0);
  result.lag_share.assign(zero_v.size(), 0.0);
  if (creep != nullptr) find_creep(*creep, zero_v, usable, result);
  if (rate != nullptr) find_lag(*rate, zero_v, usable, result);
  return result;
}

}  // namespace tactbench::analysis
