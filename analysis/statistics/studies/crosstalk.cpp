#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/studies/studies.h"

namespace tactbench::analysis {
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
