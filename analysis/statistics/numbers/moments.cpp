#include "analysis/statistics/numbers/moments.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>

namespace tactbench::analysis {

std::vector<double> finite_of(std::span<const double> values) {
  std::vector<double> finite;
  std::ranges::copy_if(values, std::back_inserter(finite), [](double value) { return std::isfinite(value); });
  return finite;
}

double mean_of(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? kNan : sum / static_cast<double>(values.size());
}

double sum_of_squares_about(std::span<const double> values, double centre) {
  double squares = 0.0;
  for (const double value : values) squares += (value - centre) * (value - centre);
  return squares;
}

double sample_variance(std::span<const double> values) {
  if (values.size() < 2) return kNan;
  return sum_of_squares_about(values, mean_of(values)) / static_cast<double>(values.size() - 1);
}

double sample_deviation(std::span<const double> values) { return std::sqrt(sample_variance(values)); }

double median_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return kNan;
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double quantile_of(std::vector<double> values, double share) {
  const auto place = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(place, values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

double quantile_between(std::span<const double> sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(place);
  const double next = sorted[std::min(low + 1, sorted.size() - 1)];
  return sorted[low] + (next - sorted[low]) * (place - static_cast<double>(low));
}

Between place_among(std::span<const double> rising, double at) {
  const auto above = static_cast<std::size_t>(std::ranges::lower_bound(rising, at) - rising.begin());
  if (above == rising.size()) return {above - 1, above - 1, 0.0};
  if (above == 0 || rising[above] == at) return {above, above, 0.0};  // of one alone: the other may be none
  return {above - 1, above, (at - rising[above - 1]) / (rising[above] - rising[above - 1])};
}

double LineFit::correlation() const { return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0; }

LineFit line_fit(std::span<const double> x, std::span<const double> y) {
  LineFit line{mean_of(x), mean_of(y)};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = x[i] - line.mean_x, dy = y[i] - line.mean_y;
    line.xx += dx * dx;
    line.yy += dy * dy;
    line.xy += dx * dy;
  }
  return line;
}

double residual_sum_of_squares(const LineFit& line, std::span<const double> x, std::span<const double> y) {
  const double slope = line.slope();
  double squares = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double off = y[i] - line.mean_y - slope * (x[i] - line.mean_x);
    squares += off * off;
  }
  return squares;
}

GroupedScatter grouped_scatter(std::span<const std::vector<double>> groups) {
  GroupedScatter out;
  double all = 0.0, squares_within = 0.0, squares_between = 0.0, n_squares = 0.0;
  for (const std::vector<double>& own : groups) {
    if (own.empty()) continue;
    const auto n = static_cast<double>(own.size());
    out.groups += 1.0;
    out.readings += n;
    n_squares += n * n;
    for (const double value : own) all += value;
  }
  all /= out.readings;
  for (const std::vector<double>& own : groups) {
    if (own.empty()) continue;
    const double mean = mean_of(own);
    squares_within += sum_of_squares_about(own, mean);
    squares_between += static_cast<double>(own.size()) * (mean - all) * (mean - all);
  }
  out.within_dof = out.readings - out.groups;
  out.between_dof = out.groups - 1.0;
  if (out.within_dof > 0.0) out.within = squares_within / out.within_dof;
  if (!(out.between_dof > 0.0)) return out;
  const double size = (out.readings - n_squares / out.readings) / out.between_dof;  // of a group, where they differ
  out.between = std::max(0.0, (squares_between / out.between_dof - out.within) / size);
  return out;
}

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

double student_quantile(double probability, double degrees_of_freedom) {
  if (!(probability > 0.0 && probability < 1.0 && degrees_of_freedom > 0.0))
    return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(degrees_of_freedom)) return boost::math::quantile(boost::math::normal(), probability);
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double student_two_sided(double t, double degrees_of_freedom) {
  if (std::isnan(t) || !(degrees_of_freedom > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(t)) return 0.0;
  if (std::isinf(degrees_of_freedom))
    return 2.0 * boost::math::cdf(boost::math::complement(boost::math::normal(), std::abs(t)));
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(degrees_of_freedom), std::abs(t)));
}

double coverage_factor(double dof, double probability) {
  if (!(dof >= 1.0) || !(probability > 0.0 && probability < 1.0))
    throw std::invalid_argument("a coverage factor needs one degree of freedom or more and a probability within 0..1");
  return student_quantile(0.5 + 0.5 * probability, std::floor(dof + 1e-9));
}

double combined_uncertainty(std::span<const VarianceShare> shares) {
  double sum = 0.0;
  for (const VarianceShare& share : shares) sum += share.u * share.u;
  return std::sqrt(sum);
}

double effective_dof(std::span<const VarianceShare> shares) {
  const double combined = combined_uncertainty(shares);
  double sum = 0.0;
  for (const VarianceShare& share : shares)
    if (std::isfinite(share.dof) && share.u > 0.0 && combined > 0.0) sum += std::pow(share.u / combined, 4) / share.dof;
  return sum > 0.0 ? 1.0 / sum : kInfiniteDof;
}

namespace {

constexpr std::size_t kHighest = 6;          // order
constexpr std::size_t kEnough = 20;          // differences for a median
constexpr std::size_t kFew = 2;              // the same, of short histories
constexpr std::size_t kLooked = 20'000;      // differences an order that are looked at, of longer stretches every n-th
constexpr double kMedianOfNormal = 0.67449;  // of its absolute value, in standard deviations
using Weights = std::array<double, kHighest + 1>;

// Weights of the difference of the samples at `x`, `order` + 1 of them: 1 / prod (x_i - x_j) [divided difference], of
// unit norm, so that noise keeps its size. None where two inputs are one.
std::optional<Weights> weights_of(std::span<const double> x) {
  Weights weights{};
  const double length = x.back() - x.front() == 0.0 ? 1.0 : std::abs(x.back() - x.front());
  double norm = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    double product = 1.0;
    for (std::size_t j = 0; j < x.size(); ++j)
      if (j != i) product *= (x[i] - x[j]) / length;
    if (product == 0.0) return std::nullopt;
    weights[i] = 1.0 / product;
    norm += weights[i] * weights[i];
  }
  norm = std::sqrt(norm);
  if (!std::isfinite(norm)) return std::nullopt;
  for (double& weight : weights) weight /= norm;
  return weights;
}

struct Estimate {
  double noise = 0.0;
  std::size_t count = 0;
};

Estimate estimate_of(std::span<const Stretch> stretches, std::size_t order, bool divided) {
  constexpr std::array<double, kHighest + 1> kEvenPlaces = {0, 1, 2, 3, 4, 5, 6};
  const Weights even = *weights_of(std::span(kEvenPlaces).first(order + 1));
  std::size_t all = 0;
  for (const Stretch& stretch : stretches) all += stretch.y.size() > order ? stretch.y.size() - order : 0;
  const std::size_t stride = 1 + all / kLooked;
  std::vector<double> sizes;
  for (const Stretch& stretch : stretches) {
    for (std::size_t i = 0; i + order < stretch.y.size(); i += stride) {
      const std::optional<Weights> weights = divided ? weights_of(stretch.x.subspan(i, order + 1)) : even;
      if (!weights) continue;
      double difference = 0.0;
      for (std::size_t k = 0; k <= order; ++k) difference += (*weights)[k] * stretch.y[i + k];
      sizes.push_back(std::abs(difference));
    }
  }
  const std::size_t count = sizes.size();
  return {count == 0 ? 0.0 : quantile_of(std::move(sizes), 0.5) / kMedianOfNormal, count};
}

}  // namespace

double difference_noise(std::span<const Stretch> stretches) {
  const bool placed = std::ranges::none_of(stretches, [](const Stretch& s) { return s.x.empty(); });
  std::vector<Estimate> estimates;
  for (std::size_t order = 1; order <= kHighest; ++order) {
    estimates.push_back(estimate_of(stretches, order, false));
    if (placed) estimates.push_back(estimate_of(stretches, order, true));
  }
  for (const std::size_t enough : {kEnough, kFew, std::size_t{1}}) {
    std::optional<double> least;
    for (const Estimate& own : estimates)
      if (own.count >= enough) least = std::min(least.value_or(own.noise), own.noise);
    if (least) return *least;
  }
  return 0.0;
}

}  // namespace tactbench::analysis
