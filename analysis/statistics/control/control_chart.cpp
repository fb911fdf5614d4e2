#include "analysis/statistics/control/control_chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tactbench::analysis {
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
