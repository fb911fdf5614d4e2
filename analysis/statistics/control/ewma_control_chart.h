// EWMA control chart of one figure: an exponentially weighted moving average of the runs since a baseline, with limits
// for a mean and a deviation that are estimated from few runs.
#pragma once

#include <optional>
#include <span>

namespace tactbench::analysis {

inline constexpr double kEwmaWeight = 0.2;          // lambda: Lucas and Saccucci 1990, Technometrics 32, 1
inline constexpr int kMinStartUpRuns = 8;           // runs of a baseline that a chart can begin with
inline constexpr int kRecommendedStartUpRuns = 20;  // runs of a baseline that a chart should begin with
inline constexpr int kControlRuns = 60;             // runs over which the rate of false alarms is stated
inline constexpr double kGrossFalseAlarm = 1e-5;  // a run: that one value of a sound figure lies outside its wide band

// z_0 = 0, z_t = lambda u_t + (1 - lambda) z_(t-1), u = (x - mean) / s; mean and s of the n start-up values. Of normal
// values with unknown mean and deviation,
//   z_t / sqrt(lambda / (2 - lambda) (1 - (1 - lambda)^2t) + (1 - (1 - lambda)^t)^2 / n)
// is distributed as Student's t with n - 1 degrees of freedom, exactly, at each t: the second term is the uncertainty
// of the mean, t that of s. What an estimated mean and s do to an EWMA otherwise: Jones, Champ and Rigdon 2001,
// Technometrics 43, 156.
struct EwmaState {
  int start_up = 0, later = 0;  // numbers of values; later: those in the average
  double mean = 0.0, deviation = 0.0;
  double ewma = 0.0;       // z, in start-up deviations
  double statistic = 0.0;  // Student's t; 0 without later values
};

class EwmaControlChart {
 public:
  // None from fewer than kMinStartUpRuns start-up values or from equal ones (1e-9 of their mean). All finite.
  static std::optional<EwmaControlChart> begin(std::span<const double> start_up);

  // A value outside the wide band (control_band() at kGrossFalseAlarm) stays out of the average: it is a gross change,
  // reported by itself, and would alarm for days after it was mended. Finite.
  void add(double value);
  [[nodiscard]] const EwmaState& state() const { return state_; }
  // Probability that a figure without a change has this statistic, or a larger one, in any of the first kControlRuns
  // runs after its baseline.
  [[nodiscard]] double probability() const;

 private:
  EwmaState state_;
  double most_ = 0.0;  // |u| at the wide band's limits
  double left_ = 1.0;  // (1 - lambda)^t
};

// Probability of |statistic| or more in any of the first kControlRuns runs, n >= kMinStartUpRuns start-up values:
// Student's probability of one run times the number of independent runs that the sixty are worth, which is tabulated
// (see the source).
double ewma_probability(double statistic, int start_up);

}  // namespace tactbench::analysis
