#include "analysis/statistics/control/ewma_control_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

// Independent runs that kControlRuns are worth: the probability that |statistic| reaches a value in any of them,
// divided by the probability that it does in one, by 1/n (rows) and by the probability of one run in half decades from
// 1 to 1e-6 (columns). By simulation: 4 million histories of an EWMA a row (40 million in the last), each averaged over
// all s exactly, since s is independent of the EWMA's numerator; relative standard error 2 % in the last
// column, below 0.5 % in the first nine. tests/analysis/statistics/control/ewma_table_slow.cpp draws them again.
constexpr std::size_t kSizes = 8, kDecades = 13;
constexpr std::array<double, kSizes> kStartUps = {8, 10, 12, 15, 20, 30, 60, INFINITY};
constexpr std::array<std::array<double, kDecades>, kSizes> kWorth = {{
    {1, 3.069, 6.149, 8.650, 10.49, 11.82, 12.78, 13.47, 13.96, 14.32, 14.57, 14.75, 14.89},
    {1, 3.112, 6.747, 10.01, 12.57, 14.54, 16.03, 17.17, 18.05, 18.71, 19.22, 19.61, 19.92},
    {1, 3.132, 7.185, 11.10, 14.29, 16.80, 18.77, 20.32, 21.54, 22.51, 23.27, 23.88, 24.37},
    {1, 3.147, 7.661, 12.40, 16.38, 19.59, 22.16, 24.22, 25.89, 27.23, 28.33, 29.22, 29.95},
    {1, 3.156, 8.166, 13.96, 18.96, 23.02, 26.29, 28.94, 31.12, 32.92, 34.43, 35.71, 36.79},
    {1, 3.160, 8.678, 15.83, 22.15, 27.22, 31.25, 34.45, 36.99, 39.02, 40.63, 41.89, 42.84},
    {1, 3.162, 9.167, 18.09, 26.14, 32.31, 36.89, 40.40, 43.18, 45.39, 47.16, 48.60, 49.83},
    {1, 3.162, 9.575, 20.62, 30.89, 37.87, 42.87, 46.02, 48.76, 50.14, 52.11, 53.52, 54.45},
}};

double worth_in_row(std::size_t row, double place) {
  const auto column = std::min(static_cast<std::size_t>(place), kDecades - 2);
  const double share = std::min(place - static_cast<double>(column), 1.0);
  return std::lerp(kWorth[row][column], kWorth[row][column + 1], share);
}

}  // namespace

double ewma_probability(double statistic, int start_up) {
  const double one_run = student_two_sided(statistic, start_up - 1.0);
  if (!(one_run > 0.0)) return 0.0;
  const double place = -2.0 * std::log10(one_run);
  std::size_t row = 0;
  while (row + 2 < kSizes && kStartUps[row + 1] < start_up) ++row;
  const double from = 1.0 / kStartUps[row], to = 1.0 / kStartUps[row + 1];
  const double share = (from - 1.0 / start_up) / (from - to);
  return std::min(1.0, one_run * std::lerp(worth_in_row(row, place), worth_in_row(row + 1, place), share));
}

std::optional<EwmaControlChart> EwmaControlChart::begin(std::span<const double> start_up) {
  if (start_up.size() < kMinStartUpRuns) return std::nullopt;
  EwmaControlChart chart;
  chart.state_.start_up = static_cast<int>(start_up.size());
  chart.state_.mean = mean_of(start_up);
  chart.state_.deviation = sample_deviation(start_up);
  if (!(chart.state_.deviation > 1e-9 * std::abs(chart.state_.mean))) return std::nullopt;
  const double n = chart.state_.start_up;
  chart.most_ = student_quantile(1.0 - kGrossFalseAlarm / 2.0, n - 1.0) * std::sqrt(1.0 + 1.0 / n);
  return chart;
}

void EwmaControlChart::add(double value) {
  const double u = (value - state_.mean) / state_.deviation;
  if (std::abs(u) > most_) return;
  ++state_.later;
  state_.ewma = kEwmaWeight * u + (1.0 - kEwmaWeight) * state_.ewma;
  left_ *= 1.0 - kEwmaWeight;
  const double gone = 1.0 - left_;
  const double variance =
      kEwmaWeight / (2.0 - kEwmaWeight) * (1.0 - left_ * left_) + gone * gone / static_cast<double>(state_.start_up);
  state_.statistic = state_.ewma / std::sqrt(variance);
}

double EwmaControlChart::probability() const { return ewma_probability(state_.statistic, state_.start_up); }

}  // namespace tactbench::analysis
