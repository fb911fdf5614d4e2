// Compares the values of a figure with its baseline: by a control chart of an exponentially weighted moving average
// (EWMA), with limits for a mean and a deviation that are estimated from few runs; by a wide band for gross changes; or
// exactly. And which of many figures, judged together, are reported as changed.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace tactbench::analysis {

// Prediction interval for one further value of a normal sample: mean -+ t(1 - alpha/2, n - 1) s sqrt(1 + 1/n)
// (Hahn and Meeker, Statistical Intervals, 4.7). All in the values' unit.
struct ControlBand {
  double mean = 0.0, deviation = 0.0;  // deviation: of the sample, n - 1
  double low = 0.0, high = 0.0;
  int values = 0;
  [[nodiscard]] bool holds(double value) const { return value >= low && value <= high; }
};

// `false_alarm`: alpha, the probability that a value of the same kind falls outside. Equal values give a band of
// rounding width (1e-9 of the value): any change is outside. None from fewer than three values or from one that is not
// finite.
std::optional<ControlBand> control_band(std::span<const double> values, double false_alarm);

// Theil-Sen slope of values in time order, a run: the median of (x_j - x_i) / (j - i), i < j (Sen 1968, J. Am. Stat.
// Assoc. 63, 1379). A description, no test. None from fewer than four values or from one that is not finite.
std::optional<double> theil_sen_slope(std::span<const double> values);

inline constexpr double kEwmaWeight = 0.2;          // lambda: Lucas and Saccucci 1990, Technometrics 32, 1
inline constexpr int kMinStartUpRuns = 8;           // runs of a baseline that a chart can begin with
inline constexpr int kRecommendedStartUpRuns = 20;  // runs of a baseline that a chart should begin with
inline constexpr int kControlRuns = 60;             // runs over which the rate of false alarms is stated
inline constexpr double kGrossFalseAlarm = 1e-5;  // a run: that one value of a sound figure lies outside its wide band

// z_0 = 0, z_t = lambda u_t + (1 - lambda) z_(t-1), u = (x - mean) / s; mean and s of the n start-up values. Of normal
// values with neither mean nor deviation known,
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

inline constexpr double kFalseDiscoveryRate = 0.05;

// Step-up procedure of Benjamini and Hochberg 1995 (J. R. Stat. Soc. B 57, 289): with the m probabilities sorted, those
// up to the largest k with p_(k) <= rate k / m are reported. The expected share of false ones among those reported is
// at most `rate`, for figures that are independent or positively dependent (Benjamini and Yekutieli 2001). One place a
// probability.
std::vector<bool> discoveries(std::span<const double> probabilities, double rate = kFalseDiscoveryRate);

enum class FigureKind {
  kMean,    // of many samples or taxels: close to normal
  kMaximum  // the largest of many, without sign: skewed, charted by its logarithm
};
// Of the figures of runs, rigs and scenarios, by name (evaluation.h, rig_figures.h); kMean for any other. Counts
// (frames, taxels that are not fitted) are constants in sound runs; one that varied in the start-up is charted as a
// mean is.
FigureKind figure_kind(std::string_view name);

struct ControlChart {
  FigureKind kind = FigureKind::kMean;
  bool constant = false;            // all start-up values are equal (1e-9): the band has the width of rounding
  bool logarithmic = false;         // a maximum whose values are all above 0: band and chart are of logarithms
  std::optional<ControlBand> band;  // the wide one, in the figure's unit; none from fewer than three start-up values
  std::optional<EwmaState> ewma;    // after the last later value, of logarithms where so said; none from fewer than
                                    // kMinStartUpRuns start-up values, from equal ones, or without later values
  double probability = 1.0;         // EwmaControlChart::probability()
  double level = 0.0;               // the EWMA in the figure's unit; with `ewma`
  std::optional<double> slope;      // Theil-Sen, of the last fourteen later values, in the figure's unit a run
};

// All values finite, in time order.
ControlChart control_chart(std::string_view name, std::span<const double> start_up, std::span<const double> later);

}  // namespace tactbench::analysis
