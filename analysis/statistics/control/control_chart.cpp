#include "analysis/statistics/control/control_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

bool every_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

}  // namespace

std::optional<ControlBand> control_band(std::span<const double> values, double false_alarm) {
  if (values.size() < 3 || !every_finite(values)) return std::nullopt;
  const double n = static_cast<double>(values.size());
  ControlBand band;
  band.values = static_cast<int>(values.size());
  band.mean = mean_of(values);
  band.deviation = sample_deviation(values);
  const double half =
      std::max(student_quantile(1.0 - false_alarm / 2.0, n - 1.0) * band.deviation * std::sqrt(1.0 + 1.0 / n),
               1e-9 * std::abs(band.mean));
  band.low = band.mean - half;
  band.high = band.mean + half;
  return band;
}

std::optional<double> theil_sen_slope(std::span<const double> values) {
  if (values.size() < 4 || !every_finite(values)) return std::nullopt;
  std::vector<double> slopes;
  for (std::size_t j = 1; j < values.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) slopes.push_back((values[j] - values[i]) / static_cast<double>(j - i));
  return median_of(std::move(slopes));
}

namespace {

// Independent runs that kControlRuns are worth: the probability that |statistic| reaches a value in any of them,
// divided by the probability that it does in one, by 1/n (rows) and by the probability of one run in half decades from
// 1 to 1e-6 (columns). By simulation: 4 million histories of an EWMA a row (40 million in the last), each averaged over
// all s exactly, since s is independent of the EWMA's numerator; relative standard error 2 % in the last
// column, below 0.5 % in the first nine. tests/analysis/statistics/sensor/sensor_slow.cpp draws them again.
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

std::vector<bool> discoveries(std::span<const double> probabilities, double rate) {
  std::vector<double> sorted(probabilities.begin(), probabilities.end());
  std::ranges::sort(sorted);
  double limit = -1.0;
  for (std::size_t k = 0; k < sorted.size(); ++k)
    if (sorted[k] <= rate * static_cast<double>(k + 1) / static_cast<double>(sorted.size())) limit = sorted[k];
  std::vector<bool> reported;
  for (const double probability : probabilities) reported.push_back(probability <= limit);
  return reported;
}

namespace {

constexpr std::size_t kSlopeRuns = 14;

// The one list of maxima that are never below 0. Those with a sign (regulator_hysteresis_psi, hold_drift_psi_per_min,
// reference_minus_feedback_psi, force_zero_drift_n) have no logarithm.
constexpr std::array<std::string_view, 7> kMaxima = {
    "hysteresis_max_percent_fs", "max_error_psi",         "worst_taxel_error_psi", "noisiest_taxel_mv", "overshoot_psi",
    "repeatability_psi",         "stage_repeatability_um"};

bool above_zero(double value) { return value > 0.0; }

// The EWMA of `start_up` and `later`, which may be logarithms.
void follow_ewma(ControlChart& chart, std::span<const double> start_up, std::span<const double> later) {
  std::optional<EwmaControlChart> ewma = EwmaControlChart::begin(start_up);
  if (!ewma) return;
  for (const double value : later) ewma->add(value);
  if (ewma->state().later == 0) return;
  chart.ewma = ewma->state();
  chart.probability = ewma->probability();
  chart.level = chart.ewma->mean + chart.ewma->ewma * chart.ewma->deviation;
}

std::vector<double> logarithms(std::span<const double> values) {
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  return logs;
}

}  // namespace

FigureKind figure_kind(std::string_view name) {
  return std::ranges::find(kMaxima, name) == kMaxima.end() ? FigureKind::kMean : FigureKind::kMaximum;
}

ControlChart control_chart(std::string_view name, std::span<const double> start_up, std::span<const double> later) {
  ControlChart chart;
  chart.kind = figure_kind(name);
  chart.slope = theil_sen_slope(later.last(std::min(kSlopeRuns, later.size())));
  chart.band = control_band(start_up, kGrossFalseAlarm);
  chart.constant = chart.band && !(chart.band->deviation > 1e-9 * std::abs(chart.band->mean));
  if (!chart.band || chart.constant) return chart;
  chart.logarithmic = chart.kind == FigureKind::kMaximum && std::ranges::all_of(start_up, above_zero) &&
                      std::ranges::all_of(later, above_zero);
  if (!chart.logarithmic) {
    follow_ewma(chart, start_up, later);
    return chart;
  }
  const std::vector<double> logs = logarithms(start_up);
  const std::optional<ControlBand> band = control_band(logs, kGrossFalseAlarm);
  chart.band->low = std::exp(band->low);
  chart.band->high = std::exp(band->high);
  follow_ewma(chart, logs, logarithms(later));
  if (chart.ewma) chart.level = std::exp(chart.level);
  return chart;
}

}  // namespace tactbench::analysis
