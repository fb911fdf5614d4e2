#include "analysis/statistics/numbers/pooled_scatter.h"

#include <algorithm>
#include <cmath>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

PooledScatter pooled_scatter(std::span<const std::vector<double>> rows) {
  PooledScatter scatter;
  scatter.rows = rows.size();
  if (rows.size() < 2) return scatter;
  std::vector<double> sums(rows.size(), 0.0);
  double variances = 0.0;
  for (std::size_t part = 0; part < rows.front().size(); ++part) {
    std::vector<double> values;
    for (const std::vector<double>& row : rows) values.push_back(row.at(part));
    if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) continue;
    ++scatter.parts;
    variances += sample_variance(values);
    for (std::size_t row = 0; row < rows.size(); ++row) sums[row] += values[row];
  }
  if (scatter.parts == 0) return scatter;
  const auto parts = static_cast<double>(scatter.parts), n = static_cast<double>(rows.size());
  for (double& sum : sums) sum /= parts;
  const double whole = variances / parts;
  const double common = std::min(whole, sample_variance(sums)), own = whole - common;
  scatter.s = std::sqrt(whole);
  scatter.dof = n - 1.0;
  if (whole > 0.0 && parts > 1.0)
    scatter.dof = std::max(scatter.dof, (n - 1.0) * whole * whole / (common * common + own * own / (parts - 1.0)));
  return scatter;
}

}  // namespace tactbench::analysis
