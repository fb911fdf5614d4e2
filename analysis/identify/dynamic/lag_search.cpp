#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/dynamic/track.h"

namespace tactbench::analysis {
namespace {

struct LagRow {
  double slope, still;     // dV/dp, and what is still to come, of the fast repeat less the slow one
  std::size_t fast, slow;  // samples
};

}  // namespace

// The outputs, creep undone, of two repeats at the same step differ by slope * (difference of what has arrived).
void find_lag(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
              ArrayDynamics& result) {
  const Track track = track_of(data);
  const auto width = zero_v.size();
  const auto psi = walk_creep(track, result.shared);
  // Pairs of samples of the same step in the fastest and the slowest repeat of a sequence.
  std::vector<LagRow> rows;
  std::size_t begin = 0;
  for (const SequenceData& sequence : data.sequences) {
    if (sequence.repeats.empty()) continue;
    const std::size_t length = sequence.repeats.front().steps.size();
    std::size_t fast = 0, slow = 0;
    const auto lasts = [&](std::size_t r) {
      const std::vector<Sample>& steps = sequence.repeats[r].steps;
      return steps.back().time_s - steps.front().time_s;
    };
    for (std::size_t r = 0; r < sequence.repeats.size(); ++r) {
      if (lasts(r) < lasts(fast)) fast = r;
      if (lasts(r) > lasts(slow)) slow = r;
    }
    if (lasts(slow) > 2.0 * lasts(fast))
      for (std::size_t i = 1; i + 1 < length; ++i)
        rows.push_back({0.0, 0.0, begin + fast * length + i, begin + slow * length + i});
    begin += sequence.repeats.size() * length;
  }
  // A turn has no slope.
  std::erase_if(rows, [&](const LagRow& row) {
    return (track.pressure[row.slow + 1] - track.pressure[row.slow]) *
               (track.pressure[row.slow] - track.pressure[row.slow - 1]) <=
           0.0;
  });
  result.rate_samples = static_cast<int>(rows.size());
  if (rows.empty()) return;
  const auto undone = [&](std::size_t taxel, std::size_t i) {
    double factor = 1.0;
    for (std::size_t j = 0; j < kCreepElements; ++j)
      factor += result.creep_scale[taxel] * result.shared.creep_share[j] * (psi[i][j] - 1.0);
    return (track.volts[i][taxel] - zero_v[taxel]) / factor;
  };
  const auto still_to_come = [&](double lag_s) {
    Dynamics d;
    d.lag_s = lag_s;
    DynamicsState state;
    std::vector<double> still;
    for (std::size_t i = 0; i < track.time.size(); ++i) {
      const DynamicsStep step = next_step(d, state, *track.samples[i], i == 0 ? -1.0 : track.time[i - 1], track.span);
      advance(d, state, step, track.pressure[i]);
      still.push_back(state.late - track.pressure[i]);
    }
    return still;
  };
  struct Share {
    double share, doubt2, rest;
  };
  const auto share_of = [&](const std::vector<double>& output, const std::vector<double>& still) {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    for (const LagRow& row : rows) {
      const double slope =
          (output[row.slow + 1] - output[row.slow - 1]) / (track.pressure[row.slow + 1] - track.pressure[row.slow - 1]);
      const double x = slope * (still[row.fast] - still[row.slow]);
      const double y =
          output[row.fast] - output[row.slow] - slope * (track.pressure[row.fast] - track.pressure[row.slow]);
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
    if (xx <= 0.0) return Share{0.0, std::numeric_limits<double>::infinity(), yy};
    const double share = xy / xx, rest = yy - share * xy;
    return Share{share, rest / static_cast<double>(rows.size()) / xx, rest};
  };
  std::vector<std::vector<double>> outputs(width);
  std::vector<double> mean(track.time.size(), 0.0);
  double count = 0.0;
  for (std::size_t t = 0; t < width; ++t) {
    if (!usable[t]) continue;
    count += 1.0;
    for (std::size_t i = 0; i < track.time.size(); ++i) outputs[t].push_back(undone(t, i));
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += outputs[t][i];
  }
  for (double& at : mean) at /= count;
  double least = std::numeric_limits<double>::infinity();
  for (double lag_s = 0.1; lag_s <= 12.0; lag_s *= 1.1) {
    const Share share = share_of(mean, still_to_come(lag_s));
    if (share.rest >= least || share.share <= 0.0) continue;
    least = share.rest;
    result.shared.lag_s = lag_s;
    result.shared.lag_share = std::min(share.share, 0.5);
  }
  const std::vector<double> still = still_to_come(result.shared.lag_s);
  for (std::size_t t = 0; t < width; ++t) {
    result.lag_share[t] = result.shared.lag_share;
    // Where the array has none, neither has a taxel.
    if (!usable[t] || result.shared.lag_share == 0.0) continue;
    const Share own = share_of(outputs[t], still);
    const double spread2 = std::pow(0.3 * result.shared.lag_share, 2);
    result.lag_share[t] = std::clamp(
        result.shared.lag_share + (own.share - result.shared.lag_share) * spread2 / (spread2 + own.doubt2), 0.0, 0.5);
  }
}

}  // namespace tactbench::analysis
