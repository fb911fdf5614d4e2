#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "analysis/algebra/dense.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/studies/studies.h"

namespace tactbench::analysis {
namespace {

constexpr double kLowestLevelPsi = 0.5;  // shares of less say nothing
// No estimate lies beyond the models' end. A level where so many taxels come so near to it says too little of the
// chamber, and the highest levels weigh most in a slope.
constexpr double kNearTheEndPsi = 0.3;
constexpr double kMostNearTheEnd = 0.05;  // of the taxels of one run

double array_deviation(const std::vector<double>& values) { return sample_deviation(finite_of(values)); }

// Sets of taxels and chamber cells that equations tie together. Nodes: taxels, then cells.
class TiedSets {
 public:
  explicit TiedSets(std::size_t nodes) : parent_(nodes) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t of(std::size_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void tie(std::size_t a, std::size_t b) { parent_[of(a)] = of(b); }

 private:
  std::vector<std::size_t> parent_;
};

struct TurnedEquation {
  std::size_t taxel, cell;
  double y;
};

// Least squares of one set; the constant that is free is given to the sensor. Returns the sum of squared residuals.
double solve_set(const std::vector<TurnedEquation>& equations, std::size_t taxels, TurnedMaps& maps) {
  std::vector<std::size_t> nodes;
  for (const TurnedEquation& equation : equations) {
    nodes.push_back(equation.taxel);
    nodes.push_back(taxels + equation.cell);
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  const auto index = [&](std::size_t node) {
    return static_cast<Eigen::Index>(std::ranges::lower_bound(nodes, node) - nodes.begin());
  };
  const auto rows = static_cast<Eigen::Index>(equations.size()), columns = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::VectorXd b(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const TurnedEquation& equation = equations[static_cast<std::size_t>(i)];
    a(i, index(equation.taxel)) = 1.0;
    a(i, index(taxels + equation.cell)) = 1.0;
    b(i) = equation.y;
  }
  const Eigen::VectorXd x = least_norm_solution(a, b);
  double common = 0.0, cells = 0.0;
  for (const std::size_t node : nodes) {
    if (node < taxels) continue;
    common += x(index(node));
    cells += 1.0;
  }
  common /= cells;
  for (const std::size_t node : nodes) {
    if (node < taxels)
      maps.sensor[node] = x(index(node)) + common;
    else
      maps.chamber[node - taxels] = cells > 1.0 ? x(index(node)) - common : kNan;
  }
  return (a * x - b).squaredNorm();
}

}  // namespace

std::vector<int> turned_places(int rows, int columns, int angle_deg) {
  if (angle_deg != 0 && angle_deg != 90 && angle_deg != 180 && angle_deg != 270)
    throw std::invalid_argument("an array is turned by 0, 90, 180 or 270 degrees");
  if (angle_deg % 180 != 0 && rows != columns)
    throw std::invalid_argument("an array that is not square cannot be turned by a quarter");
  std::vector<int> places;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      // A quarter counter-clockwise with row 0 on top: the last column comes to lie on top.
      const auto [r, c] = angle_deg == 0     ? std::pair(row, column)
                          : angle_deg == 90  ? std::pair(columns - 1 - column, row)
                          : angle_deg == 180 ? std::pair(rows - 1 - row, columns - 1 - column)
                                             : std::pair(column, rows - 1 - row);
      places.push_back(r * columns + c);
    }
  }
  return places;
}

TurnedMaps separate_maps(std::span<const std::vector<double>> y, std::span<const std::vector<int>> places) {
  const std::size_t taxels = y.empty() ? 0 : y.front().size();
  TurnedMaps maps;
  maps.sensor.assign(taxels, kNan);
  maps.chamber.assign(taxels, kNan);
  TiedSets sets(2 * taxels);
  std::vector<TurnedEquation> all;
  for (std::size_t run = 0; run < y.size(); ++run) {
    for (std::size_t taxel = 0; taxel < taxels; ++taxel) {
      if (!std::isfinite(y[run][taxel])) continue;
      const auto cell = static_cast<std::size_t>(places[run][taxel]);
      all.push_back({taxel, cell, y[run][taxel]});
      sets.tie(taxel, taxels + cell);
    }
  }
  std::vector<std::vector<TurnedEquation>> by_set(2 * taxels);
  for (const TurnedEquation& equation : all) by_set[sets.of(equation.taxel)].push_back(equation);
  double squares = 0.0;
  std::size_t unknowns = 0;
  for (const std::vector<TurnedEquation>& equations : by_set) {
    if (equations.empty()) continue;
    squares += solve_set(equations, taxels, maps);
    ++maps.undetermined;
  }
  std::vector<bool> seen(2 * taxels, false);
  for (const TurnedEquation& equation : all) {
    for (const std::size_t node : {equation.taxel, taxels + equation.cell}) {
      if (!seen[node]) ++unknowns;
      seen[node] = true;
    }
  }
  const auto degrees = static_cast<double>(all.size()) - static_cast<double>(unknowns) + maps.undetermined;
  maps.degrees = degrees;
  maps.residual = degrees > 0.0 ? std::sqrt(squares / degrees) : kNan;
  return maps;
}

namespace {

bool is_cut_off(const SweepEstimates& estimates, double pressure) {
  const std::size_t level = estimates.level(pressure);
  double near = 0.0;
  for (int taxel = 0; taxel < estimates.taxels; ++taxel)
    near += estimates.mean(level, taxel) > estimates.pressure_psi.back() - kNearTheEndPsi ? 1.0 : 0.0;
  return near > kMostNearTheEnd * static_cast<double>(estimates.taxels);
}

// Estimates of one run at a level less the level and less the array's mean, by taxel.
std::vector<double> off_level(const SweepEstimates& estimates, double pressure) {
  std::vector<double> out(static_cast<std::size_t>(estimates.taxels), kNan);
  const std::size_t level = estimates.level(pressure);
  double sum = 0.0, n = 0.0;
  for (int taxel = 0; taxel < estimates.taxels; ++taxel) {
    const double value = estimates.mean(level, taxel) - pressure;
    out[static_cast<std::size_t>(taxel)] = value;
    if (!std::isfinite(value)) continue;
    sum += value;
    n += 1.0;
  }
  for (double& value : out) value -= sum / n;
  return out;
}

// Each run also has a constant of its own, m(angle). Where all taxels are there a run's mean is it; where some are not,
// the residuals' means are taken off until nothing is left of them (a few rounds: what is missing is a small share).
TurnedMaps separate_level(std::span<const TurnedRun> runs, double level, std::span<const std::vector<int>> places) {
  constexpr int kRounds = 20;
  std::vector<std::vector<double>> y;
  for (const TurnedRun& run : runs) y.push_back(off_level(run.estimates, level));
  TurnedMaps maps;
  for (int round = 0; round < kRounds; ++round) {
    maps = separate_maps(y, places);
    double moved = 0.0;
    for (std::size_t run = 0; run < y.size(); ++run) {
      double sum = 0.0, n = 0.0;
      for (std::size_t taxel = 0; taxel < y[run].size(); ++taxel) {
        const double chamber = maps.chamber[static_cast<std::size_t>(places[run][taxel])];
        const double off = y[run][taxel] - maps.sensor[taxel] - (std::isfinite(chamber) ? chamber : 0.0);
        if (!std::isfinite(off)) continue;
        sum += off;
        n += 1.0;
      }
      const double mean = n > 0.0 ? sum / n : 0.0;
      moved = std::max(moved, std::abs(mean));
      for (double& value : y[run]) value -= mean;
    }
    if (moved < 1e-13) break;
  }
  const double constants = static_cast<double>(runs.size()) - 1.0;
  maps.residual =
      maps.degrees > constants ? maps.residual * std::sqrt(maps.degrees / (maps.degrees - constants)) : kNan;
  return maps;
}

// Of y over x, where y is finite.
LineFit line_over(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> own;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(y[i])) own.push_back(x[i]);
  return line_fit(own, finite_of(y));
}

double residual_over_levels(std::span<const TurnedRun> runs, const std::vector<double>& levels,
                            std::span<const std::vector<int>> places) {
  double squares = 0.0;
  for (const double level : levels) {
    const double residual = separate_level(runs, level, places).residual;
    squares += residual * residual;
  }
  return std::sqrt(squares / static_cast<double>(levels.size()));
}

}  // namespace

Uniformity uniformity_of(std::span<const TurnedRun> runs, int rows, int columns) {
  Uniformity u;
  std::vector<std::vector<int>> places, other_sense;
  for (const TurnedRun& run : runs) {
    u.runs.push_back(run.run);
    u.angles_deg.push_back(run.angle_deg);
    places.push_back(turned_places(rows, columns, run.angle_deg));
    other_sense.push_back(turned_places(rows, columns, (360 - run.angle_deg) % 360));
  }
  if (std::ranges::all_of(u.angles_deg, [&](int angle) { return angle == u.angles_deg.front(); })) return u;
  for (const double level : runs.front().estimates.pressure_psi) {
    const bool everywhere = std::ranges::all_of(
        runs, [&](const TurnedRun& run) { return run.estimates.level(level) < run.estimates.pressure_psi.size(); });
    if (!everywhere || !(level > kLowestLevelPsi)) continue;
    if (std::ranges::any_of(runs, [&](const TurnedRun& run) { return is_cut_off(run.estimates, level); })) continue;
    u.pressure_psi.push_back(level);
  }
  if (u.pressure_psi.size() < 2) {
    u.not_assessed = "the runs turned in the chamber have fewer than two levels in common below the models' end";
    return u;
  }
  const auto taxels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  std::vector<std::vector<double>> chamber(taxels), sensor(taxels);  // by cell, over the levels
  double squares = 0.0;
  for (const double level : u.pressure_psi) {
    const TurnedMaps maps = separate_level(runs, level, places);
    u.u_psi.push_back(array_deviation(maps.chamber));
    u.residual_psi.push_back(maps.residual);
    squares += maps.residual * maps.residual;
    u.undetermined = maps.undetermined;
    for (std::size_t i = 0; i < taxels; ++i) {
      chamber[i].push_back(maps.chamber[i]);
      sensor[i].push_back(maps.sensor[i]);
    }
  }
  for (std::size_t i = 0; i < taxels; ++i) {
    const LineFit line = line_over(u.pressure_psi, chamber[i]);
    u.chamber_share.push_back(line.slope());
    u.chamber_psi.push_back(line.at_zero());
    u.sensor_share.push_back(line_over(u.pressure_psi, sensor[i]).slope());
  }
  u.u_share = array_deviation(u.chamber_share);
  u.degrees = std::max(1.0, static_cast<double>(finite_of(u.chamber_share).size()) - u.undetermined);
  u.u_offset_psi = array_deviation(u.chamber_psi);
  u.residual_rms_psi = std::sqrt(squares / static_cast<double>(u.pressure_psi.size()));
  u.residual_other_sense_psi = residual_over_levels(runs, u.pressure_psi, other_sense);
  u.not_assessed.clear();
  return u;
}

}  // namespace tactbench::analysis
