#include "analysis/statistics/studies/studies.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/identify/sensor_model.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/reading_errors.h"

namespace tactbench::analysis {
namespace {

constexpr double kSamePace = 1.2;  // repeats whose durations differ by a smaller factor have the same pace

double length_s(const Repeat& repeat) { return repeat.steps.back().time_s - repeat.steps.front().time_s; }

// Mean output of the fitted taxels in a frame.
double mean_output(const Repeat& repeat, std::size_t step, const Fitted& fitted) {
  return mean_of(fitted.row(repeat.volts, step));
}

void compare_paces(const SequenceData& sequence, const Fitted& fitted, double full_scale_v, RateHoldRun& out) {
  const auto slowest = std::ranges::max_element(sequence.repeats, {}, length_s);
  double sum = 0.0;
  int samples = 0;
  for (const Repeat& repeat : sequence.repeats) {
    if (&repeat == &*slowest || length_s(repeat) * kSamePace > length_s(*slowest)) continue;
    for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
      const double off = std::abs(mean_output(repeat, i, fitted) - mean_output(*slowest, i, fitted)) / full_scale_v;
      out.output_max_share = std::max(out.output_max_share, off);
      sum += off;
      ++samples;
    }
  }
  if (samples > 0) out.output_mean_share = sum / samples;
}

}  // namespace

std::vector<RateHoldRun> rate_hold_of(const Dataset& measured, const SensorModel& fit, int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const Fitted fitted(fit);
  const FrameErrors errors = frame_errors(dataset, fit, threads);
  std::vector<Score> sums(dataset.sequences.size());
  for (const std::size_t taxel : fitted.taxels()) {
    std::vector<Score> own(sums.size());
    for (std::size_t at = 0; at < errors.frames.size(); ++at) {
      const FrameErrors::Frame& frame = errors.frames[at];
      const std::vector<Sample>& steps = dataset.sequences[frame.sequence].repeats[frame.repeat].steps;
      const std::size_t i = frame.step;
      const double passed = i > 0 ? steps[i].time_s - steps[i - 1].time_s : 0.0;
      const double rate = passed > 0.0 ? std::abs(frame.reference_psi - steps[i - 1].reference_psi) / passed : 0.0;
      // A level that is held has no rate but noise.
      const bool moved = i > 0 && frame.setpoint_psi != steps[i - 1].setpoint_psi;
      own[frame.sequence].add_sample(std::abs(errors.error_psi[at * fitted.width() + taxel]), steps[i].held_s,
                                     moved ? rate : 0.0);
    }
    for (std::size_t s = 0; s < sums.size(); ++s) sums[s].add(own[s]);
  }
  std::vector<RateHoldRun> runs;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const Score& sum = sums[s];
    RateHoldRun run{dataset.run, dataset.sequences[s].name, sum.compensated, sum.by_hold, sum.by_rate, 0.0, 0.0};
    compare_paces(dataset.sequences[s], fitted, fit.full_scale_v(), run);
    runs.push_back(std::move(run));
  }
  return runs;
}

namespace {

constexpr double kLowestMountPsi = 0.5;
constexpr double kShareFrom = 0.1;  // of the highest level: shares of less say more of the zero than of the mount

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
      const std::size_t level = own.level(pressure);
      for (int sweep = 0; sweep < own.sweeps; ++sweep) {
        groups[m].push_back(own.at(level, sweep, static_cast<int>(taxel)));
        finite = finite && std::isfinite(groups[m].back());
      }
    }
    if (!finite) continue;
    const GroupedScatter variances = grouped_scatter(groups);
    out.within_psi += variances.within;
    out.between_psi += variances.between;
    out.taxel_between[taxel] = variances.between;
    for (std::size_t m = 0; m < mounts.size(); ++m)
      for (std::size_t sweep = 0; sweep < groups[m].size(); ++sweep) mean[m][sweep] += groups[m][sweep];
    count += 1.0;
  }
  out.within_psi = std::sqrt(out.within_psi / count);
  out.between_psi = std::sqrt(out.between_psi / count);
  out.mean_between_psi = std::sqrt(grouped_scatter(mean).between) / count;
  return out;
}

}  // namespace

Remount remount_of(std::span<const MountedRun> mounts) {
  Remount remount;
  for (const MountedRun& mount : mounts) remount.runs.push_back(mount.run);
  if (mounts.size() < 2) return remount;
  for (const double level : mounts.front().estimates.pressure_psi) {
    const bool everywhere = std::ranges::all_of(mounts, [&](const MountedRun& mount) {
      return mount.estimates.level(level) < mount.estimates.pressure_psi.size();
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
  remount.per_taxel_share = std::sqrt(std::max(0.0, std::pow(remount.s_share, 2) - std::pow(remount.common_share, 2)));
  remount.degrees = static_cast<int>(mounts.size()) - 1;
  const auto fitted = std::ranges::count_if(remount.taxel_between_psi, [](double s) { return std::isfinite(s); });
  remount.per_taxel_degrees = remount.degrees * std::max(1, static_cast<int>(fitted) - 1);
  remount.not_assessed.clear();
  return remount;
}

namespace {

constexpr double kLeastPrintV = 0.05;    // a frame whose peak is lower shows no print
constexpr double kPrintShare = 0.1;      // of the peak: taxels above it make the print's centre
constexpr double kLineReach = 1.0;       // pitches: a row this near to the centre is loaded
constexpr double kSameForceShare = 0.1;  // forces this near to the highest are that level

// Lower quartile of each taxel's outputs: it is unloaded at more than three of four positions.
std::vector<double> baselines(std::span<const PointFrame> frames, std::size_t taxels) {
  std::vector<double> out, values;
  for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
    values.clear();
    for (const PointFrame& frame : frames) values.push_back(frame.volts[taxel]);
    out.push_back(quantile_of(values, 0.25));
  }
  return out;
}

struct Print {
  double row = 0.0, column = 0.0;
  std::vector<double> share;  // of the peak, taxels
};

Print print_of(const PointFrame& frame, const std::vector<double>& baseline, int columns) {
  Print print;
  double peak = 0.0, weight = 0.0;
  for (std::size_t i = 0; i < baseline.size(); ++i) peak = std::max(peak, frame.volts[i] - baseline[i]);
  if (peak < kLeastPrintV) return print;
  for (std::size_t i = 0; i < baseline.size(); ++i) {
    const double share = (frame.volts[i] - baseline[i]) / peak;
    print.share.push_back(share);
    if (share < kPrintShare) continue;
    const auto taxel = static_cast<int>(i);
    const int row = taxel / columns;
    print.row += share * row;
    print.column += share * (taxel % columns);
    weight += share;
  }
  print.row /= weight;
  print.column /= weight;
  return print;
}

// Shares of one zone, position by position: taxels of one frame are not independent of each other.
class ZoneSum {
 public:
  void add(std::size_t position, double share) {
    by_position_[position].push_back(share);
    zone_.max_share = std::max(zone_.max_share, share);
    ++zone_.samples;
  }
  CrosstalkZone zone() const {
    CrosstalkZone out = zone_;
    std::vector<double> means;
    for (const auto& [position, shares] : by_position_) means.push_back(mean_of(shares));
    if (means.empty()) return {kNan, kNan, kNan, 0};
    out.mean_share = mean_of(means);
    out.u_share = std::sqrt(sample_variance(means) / static_cast<double>(means.size()));
    return out;
  }

 private:
  std::map<std::size_t, std::vector<double>> by_position_;
  CrosstalkZone zone_;
};

class CrosstalkSums {
 public:
  CrosstalkSums(int rows, int columns, double reach) : rows_(rows), columns_(columns), reach_(reach) {}

  void add(std::size_t position, const Print& print) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const double share = print.share[static_cast<std::size_t>(row * columns_ + column)];
        const double down = std::abs(row - print.row), along = std::abs(column - print.column);
        const bool in_row = down <= kLineReach, in_column = along <= kLineReach;
        if (in_row) row_profile_[std::lround(along)].push_back(share);
        if (in_column) column_profile_[std::lround(down)].push_back(share);
        if (down <= reach_ && along <= reach_) continue;
        (in_row ? row_zone_ : in_column ? column_zone_ : elsewhere_zone_).add(position, share);
        if (in_row) row_lines_[row].add(position, share);
        if (in_column) column_lines_[column].add(position, share);
      }
    }
  }

  void write(Crosstalk& crosstalk) const {
    crosstalk.row = row_zone_.zone();
    crosstalk.column = column_zone_.zone();
    crosstalk.elsewhere = elsewhere_zone_.zone();
    crosstalk.ghost_rows = ghosts(row_lines_, crosstalk.elsewhere);
    crosstalk.ghost_columns = ghosts(column_lines_, crosstalk.elsewhere);
    for (long distance = 0; distance < std::max(rows_, columns_); ++distance) {
      const auto in_row = row_profile_.find(distance), in_column = column_profile_.find(distance);
      if (in_row == row_profile_.end() && in_column == column_profile_.end()) continue;
      crosstalk.distance_pitches.push_back(static_cast<double>(distance));
      crosstalk.along_row_share.push_back(in_row == row_profile_.end() ? kNan : mean_of(in_row->second));
      crosstalk.along_column_share.push_back(in_column == column_profile_.end() ? kNan : mean_of(in_column->second));
    }
  }

 private:
  static std::vector<CrosstalkLine> ghosts(const std::map<int, ZoneSum>& lines, const CrosstalkZone& elsewhere) {
    std::vector<CrosstalkLine> out;
    for (const auto& [line, sum] : lines) {
      const CrosstalkZone zone = sum.zone();
      const double beyond = zone.mean_share - elsewhere.mean_share;
      const double u = std::hypot(std::isfinite(zone.u_share) ? zone.u_share : 0.0,
                                  std::isfinite(elsewhere.u_share) ? elsewhere.u_share : 0.0);
      if (beyond > kGhostShare && beyond > 3.0 * u) out.push_back({line, zone.mean_share});
    }
    return out;
  }

  int rows_, columns_;
  double reach_;
  ZoneSum row_zone_, column_zone_, elsewhere_zone_;
  std::map<int, ZoneSum> row_lines_, column_lines_;
  std::map<long, std::vector<double>> row_profile_, column_profile_;
};

}  // namespace

Crosstalk crosstalk_of(std::int64_t run, std::span<const PointFrame> frames, int rows, int columns) {
  Crosstalk crosstalk;
  crosstalk.run = run;
  if (frames.empty()) return crosstalk;
  const auto taxels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  double highest = 0.0;
  for (const PointFrame& frame : frames) highest = std::max(highest, frame.force_n);
  const std::vector<double> baseline = baselines(frames, taxels);
  CrosstalkSums sums(rows, columns, crosstalk.reach_pitches);
  std::map<int, int> positions;
  double forces = 0.0, used = 0.0;
  for (const PointFrame& frame : frames) {
    if (!frame.rising || frame.force_n < highest * (1.0 - kSameForceShare)) continue;
    const Print print = print_of(frame, baseline, columns);
    if (print.share.empty()) continue;
    ++positions[frame.position];
    sums.add(static_cast<std::size_t>(frame.position), print);
    forces += frame.force_n;
    used += 1.0;
  }
  if (positions.size() < 4) {
    crosstalk.not_assessed = "fewer than four positions under the point indenter: a taxel's own zero is not known";
    return crosstalk;
  }
  crosstalk.positions = static_cast<int>(positions.size());
  crosstalk.force_n = forces / used;
  sums.write(crosstalk);
  crosstalk.not_assessed.clear();
  return crosstalk;
}

}  // namespace tactbench::analysis
