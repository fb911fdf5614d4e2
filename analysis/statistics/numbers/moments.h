// Means, deviations, quantiles and least-squares lines of lists of numbers, Student's distribution and coverage
// factors. Sums go from the first value to the last, so that stored and printed figures are bit-identical wherever they
// are computed.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace tactbench::analysis {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();  // a figure without data

std::vector<double> finite_of(std::span<const double> values);  // those that are, in their order

double mean_of(std::span<const double> values);  // sum / n; NaN when empty
// Of the values that `chosen` names by their places, e.g. some taxels of a frame; NaN when there are none.
template <class Place>
double mean_of_chosen(std::span<const double> values, std::span<const Place> chosen) {
  double sum = 0.0;
  for (const Place place : chosen) sum += values[static_cast<std::size_t>(place)];
  return sum / static_cast<double>(chosen.size());
}

double sum_of_squares_about(std::span<const double> values, double centre);  // sum of (value - centre)^2
// sum_of_squares_about(mean) / (n - 1) and its root: JCGM 100, 4.2.2, Eq. (4). NaN below two values.
double sample_variance(std::span<const double> values);
double sample_deviation(std::span<const double> values);

// Of the values that are finite: the middle one, or the mean of the middle two; NaN when there are none.
double median_of(std::vector<double> values);
// The value that is at place floor(share * n) when all are sorted, 0 <= share <= 1; of an even number share 0.5 gives
// the upper of the middle two. Values not empty, none of them NaN.
double quantile_of(std::vector<double> values, double share);
// Linear between the values on both sides of share * (n - 1). Values sorted, not empty.
double quantile_between(std::span<const double> sorted, double share);

// Where a value lies among rising ones: `share` of the way from one place to the next; at an end what lies beyond it,
// and NaN at the first. Of one value at least.
struct Between {
  std::size_t low = 0, high = 0;
  double share = 0.0;
};
Between place_among(std::span<const double> rising, double at);

// Least squares of y over x: sums of squares and products about the means.
struct LineFit {
  double mean_x = kNan, mean_y = kNan;
  double xx = 0.0, yy = 0.0, xy = 0.0;
  [[nodiscard]] double slope() const { return xy / xx; }  // NaN when all x are equal
  [[nodiscard]] double at_zero() const { return mean_y - slope() * mean_x; }
  [[nodiscard]] double correlation() const;  // Pearson's; 0 when x or y is constant
};
LineFit line_fit(std::span<const double> x, std::span<const double> y);  // equally long
// Sum of the squared residuals of the line.
double residual_sum_of_squares(const LineFit& line, std::span<const double> x, std::span<const double> y);

// One-way analysis of variance (JCGM 100, H.5.2) of readings in groups of unequal size; empty groups are none.
struct GroupedScatter {
  double within = 0.0, within_dof = 0.0;    // variance, degrees of freedom; 0 of one reading a group
  double between = 0.0, between_dof = 0.0;  // of the groups' effect, what `within` explains taken off, not below 0
  double groups = 0.0, readings = 0.0;
};
GroupedScatter grouped_scatter(std::span<const std::vector<double>> groups);

// Scatter of a mean from few repetitions, pooled over what the mean is taken of (JCGM 100, H.3.6, 4.2.4 note; G.4.1).
// Repetitions x parts: each row holds the same parts (taxels, levels) of one repetition; the figure is their mean.
struct PooledScatter {
  // Root of the mean over the parts of their variances from row to row, in the unit of the parts. The variance of the
  // figure is at most this, whatever the correlation of the parts (Cauchy-Schwarz), and equal when they move as one.
  double s = 0.0;
  // Of s, by Welch-Satterthwaite from its two components (two-way analysis of variance, H.5): what the parts have in
  // common, n - 1, and their own, (n - 1)(parts - 1). Between n - 1 and (n - 1) x parts.
  double dof = 0.0;
  std::size_t rows = 0, parts = 0;
  [[nodiscard]] bool known() const { return rows >= 2 && parts >= 1; }
};

// Parts that are not finite in any row are left out. Not known with fewer than two rows or without parts.
PooledScatter pooled_scatter(std::span<const std::vector<double>> rows);

// Quantiles of Student's t distribution, for prediction intervals and coverage factors (JCGM 100 annex G.3).
// t with P(T <= t) = probability, 0 < probability < 1; degrees of freedom > 0, infinite ones are the normal
// distribution's. NaN otherwise.
double student_quantile(double probability, double degrees_of_freedom);
// P(|T| >= |t|), degrees of freedom > 0. NaN otherwise.
double student_two_sided(double t, double degrees_of_freedom);

// JCGM 100, Table G.2 and 6.3.3: k = 2 for infinitely many degrees of freedom.
inline constexpr double kCoverageProbability = 0.954499736103642;
inline constexpr double kInfiniteDof = std::numeric_limits<double>::infinity();

// t_p(dof) with P(|T| <= t) = `probability` (0..1, both excluded). dof is cut to a whole number (G.4.1), infinity gives
// the normal distribution's factor. Throws std::invalid_argument for dof below 1 or another probability.
double coverage_factor(double dof, double probability = kCoverageProbability);

// One share of a combined variance: |c| u(x), and its degrees of freedom.
struct VarianceShare {
  double u = 0.0;
  double dof = kInfiniteDof;
};
// JCGM 100, Eq. (10) without correlations.
double combined_uncertainty(std::span<const VarianceShare> shares);
// Welch-Satterthwaite, JCGM 100 Eq. (G.2b); infinite when no share has a finite number.
double effective_dof(std::span<const VarianceShare> shares);

// Estimates the noise of otherwise smooth samples, from differences of neighbours that cancel slope and curvature.
// Samples in a row without a turn between them. `x`: where they lie, equally long; empty: evenly.
struct Stretch {
  std::span<const double> x, y;
};

// Standard deviation of a sample; 0 when no stretch has two. For each order from 1 to 6 the median size of the
// differences of all stretches: plain ones, and divided ones where the inputs are distinct. Each is the noise and what
// slope and curvature leave, so the least is taken, of orders with 20 differences at least; where a history is too
// short for any, with 2.
double difference_noise(std::span<const Stretch> stretches);

}  // namespace tactbench::analysis
