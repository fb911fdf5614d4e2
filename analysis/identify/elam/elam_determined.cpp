#include "analysis/identify/elam/elam_determined.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "analysis/algebra/dense.h"

namespace tactbench::analysis {
namespace {

constexpr double kAnywhere = 1.0 / 12.0;  // variance of a value drawn from 0..1
// A parameter, of residuals squared: a split at an unknown place gains more by chance than a fixed one (Andrews,
// Econometrica 1993: 11.8 for two parameters at 95 %).
constexpr double kByChance = 6.0;
constexpr double kSameJ = 1e-7;          // share
constexpr double kSmallestError = 1e-4;  // of full scale: what is taken as a sample's error at least
constexpr double kStep = 1e-5;           // of a parameter, for derivatives
constexpr int kNearer = 16;              // places on the way to the pattern

// One direction's parameters, each in 0..1: alpha_d, beta_d, or phi(0), phi(X), beta_a.
class Halved {
 public:
  using At = Eigen::VectorXd;
  Halved(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending)
      : model_(model), curves_(curves), constant_(constant), ascending_(ascending) {
    for (const CurveSamples& curve : curves) {
      rows_ += static_cast<Eigen::Index>(curve.x.size());
      for (const double weight : curve.weight) samples_ += weight;
    }
  }
  [[nodiscard]] Eigen::Index size() const { return ascending_ ? 3 : 2; }
  [[nodiscard]] At here() const {
    const std::array<double, 3> row = direction_of(model_.parameters, ascending_, length());
    return At::Map(row.data(), size());
  }
  // The pattern's own split at this share of the input range.
  [[nodiscard]] At own_split(double share) const {
    const PatternCurve& pattern = ascending_ ? model_.ascending : model_.descending;
    const double beta = (pattern(model_.x0() + share * length()) - model_.y0()) / (model_.yu() - model_.y0());
    At at = At::Constant(size(), share);
    at[size() - 1] = std::clamp(beta, 0.0, 1.0);
    return at;
  }
  void put(const At& at) { set_direction(model_.parameters, ascending_, length(), at.data()); }
  [[nodiscard]] double j(const At& at) { return constant_ + residuals(at).squaredNorm(); }
  // Directions with the variance that the samples leave in each.
  struct Spread {
    Eigen::MatrixXd directions;
    Eigen::VectorXd variances;
    bool all = false;
    [[nodiscard]] bool open(Eigen::Index parameter) const {
      return all || directions.row(parameter).cwiseAbs2().dot(variances) > kAnywhere;
    }
    [[nodiscard]] bool any_open() const {
      for (Eigen::Index k = 0; k < directions.rows(); ++k)
        if (open(k)) return true;
      return false;
    }
  };
  [[nodiscard]] Spread spread(const At& at, double j) {
    Eigen::MatrixXd slopes(rows_, size());
    for (Eigen::Index k = 0; k < size(); ++k) {
      At low = at, high = at;
      low[k] = std::max(low[k] - kStep, 0.0);
      high[k] = std::min(high[k] + kStep, 1.0);
      slopes.col(k) = (residuals(high) - residuals(low)) / (high[k] - low[k]);
    }
    const Eigen::MatrixXd normal = gram_of(slopes);
    const SymmetricEigen eigen = eigen_of(normal);
    const double least = kSmallestError * (model_.yu() - model_.y0());
    const double variance = sample_variance(j);
    const double smallest = 1e-14 * std::max(normal.trace(), least * least);
    return {eigen.vectors, (variance / eigen.values.array().max(smallest)).matrix()};
  }
  // J changes by no more than one standard error's worth as the split runs along the pattern. Derivatives do not show
  // it: at the pattern's corners those to either side differ.
  [[nodiscard]] bool open_along_pattern(double j) {
    const double most = this->j(own_split(0.5)) + sample_variance(j), way = std::sqrt(kAnywhere);
    return this->j(own_split(0.5 - way)) <= most && this->j(own_split(0.5 + way)) <= most;
  }
  [[nodiscard]] double as_good(double j) const {
    const double least = kSmallestError * (model_.yu() - model_.y0());
    const double k = static_cast<double>(size());
    return std::max(j, samples_ * least * least) * (1.0 + kByChance * k / std::max(samples_ - k, 1.0));
  }

 private:
  [[nodiscard]] double length() const { return model_.xu() - model_.x0(); }
  [[nodiscard]] double sample_variance(double j) const {
    const double least = kSmallestError * (model_.yu() - model_.y0());
    return std::max(j / std::max(samples_ - static_cast<double>(size()), 1.0), least * least);
  }
  [[nodiscard]] Eigen::VectorXd residuals(const At& at) {
    put(at);
    Eigen::VectorXd off(rows_);
    Eigen::Index row = 0;
    for (const CurveSamples& samples : curves_) {
      const ElamCurve curve(model_, ascending_, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i)
        off[row++] = std::sqrt(samples.weight[i]) * (curve.output(samples.x[i]) - samples.y[i]);
    }
    return off;
  }
  ElamModel& model_;
  std::span<const CurveSamples> curves_;
  double constant_;
  bool ascending_;
  Eigen::Index rows_ = 0;
  double samples_ = 0.0;
};

}  // namespace

unsigned settle_undetermined(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending) {
  const ElamParameters before = model.parameters;
  Halved half(model, curves, constant, ascending);
  const Halved::At found = half.here(), middle = half.own_split(0.5);
  const double j = half.j(found);
  Halved::At taken = found;
  Halved::Spread spread;
  const bool as_good = half.j(middle) <= half.as_good(j);
  if (as_good) {
    spread = half.spread(middle, j);
    spread.all = half.open_along_pattern(j);
  }
  if (as_good && spread.any_open()) {
    taken = middle;
  } else {
    spread = half.spread(found, j);
    const Eigen::VectorXd open = (spread.variances.array() > kAnywhere).cast<double>().matrix();
    const Halved::At way =
        spread.directions * open.cwiseProduct(spread.directions.transpose() * (middle - found)).eval();
    for (int k = kNearer; spread.any_open() && k > 0; --k) {
      const Halved::At to = (found + way * k / kNearer).cwiseMax(0.0).cwiseMin(1.0);
      if (half.j(to) > j * (1.0 + kSameJ)) continue;
      taken = to;
      break;
    }
  }
  half.put(taken);
  if (taken == found) model.parameters = before;  // bit for bit
  // phi(0) is alpha_a0 and stands at bit 3, phi(X) stands for alpha_a1.
  constexpr unsigned kBits[2][3] = {{0, 1, 1}, {3, 2, 4}};
  unsigned bits = 0;
  for (Eigen::Index k = 0; k < half.size(); ++k)
    if (spread.open(k)) bits |= 1U << kBits[ascending ? 1 : 0][k];
  return bits;
}

}  // namespace tactbench::analysis
