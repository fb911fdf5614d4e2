// Further split points a branch, from the optimum with one: for each way to share them between the two sides of the
// paper's split, Levenberg-Marquardt with numeric derivatives in the paper's parameters and the pieces' sizes.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/algebra/dense.h"
#include "analysis/identify/elam/elam_samples.h"

namespace tactbench::analysis {
namespace {

constexpr int kSteps = 30;
constexpr double kDifference = 1e-6;  // of a parameter, for derivatives
constexpr double kSettled = 1e-9;     // gain of a step, of J

// One direction's parameters in one row: the paper's, each in [0, 1], then the logarithms of the pieces' sizes.
class Direction {
 public:
  Direction(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending, std::size_t low,
            std::size_t high)
      : model_(model), curves_(curves), ascending_(ascending), low_(low), high_(high) {
    for (const CurveSamples& curve : curves) samples_ += static_cast<Eigen::Index>(curve.x.size());
  }
  [[nodiscard]] Eigen::Index own() const { return ascending_ ? 3 : 2; }  // the paper's parameters
  [[nodiscard]] Eigen::VectorXd start() const {
    const std::array<double, 3> row = direction_of(model_.parameters, ascending_, length());
    Eigen::VectorXd at = Eigen::VectorXd::Zero(own() + static_cast<Eigen::Index>(low_ + high_));
    at.head(own()) = Eigen::VectorXd::Map(row.data(), own());
    return clipped(at);
  }
  [[nodiscard]] Eigen::VectorXd clipped(Eigen::VectorXd at) const {
    at.head(own()) = at.head(own()).cwiseMax(0.0).cwiseMin(1.0);
    const Eigen::Index pieces = at.size() - own();
    at.tail(pieces) = at.tail(pieces).cwiseMax(-kMostPieceLog).cwiseMin(kMostPieceLog);
    return at;
  }
  void put(const Eigen::VectorXd& at, ElamModel& model, ElamPieces& pieces) const {
    set_direction(model.parameters, ascending_, length(), at.data());
    const double* logs = at.data() + own();
    (ascending_ ? pieces.ascending_low : pieces.descending_low).assign(logs, logs + low_);
    (ascending_ ? pieces.ascending_high : pieces.descending_high).assign(logs + low_, logs + low_ + high_);
  }
  [[nodiscard]] Eigen::VectorXd residuals(const Eigen::VectorXd& at, ElamModel& model) const {
    ElamPieces pieces;
    pieces.descending_low.resize(low_ + high_);  // so many splits, whichever direction is looked at
    put(at, model, pieces);
    Eigen::VectorXd off(samples_);
    Eigen::Index k = 0;
    for (const CurveSamples& samples : curves_) {
      const ElamPiecedCurve curve(model, pieces, ascending_, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i)
        off[k++] = std::sqrt(samples.weight[i]) * (curve.output(samples.x[i]) - samples.y[i]);
    }
    return off;
  }
  [[nodiscard]] ElamModel model() const { return model_; }
  [[nodiscard]] Eigen::Index samples() const { return samples_; }

 private:
  [[nodiscard]] double length() const { return model_.xu() - model_.x0(); }
  const ElamModel& model_;
  std::span<const CurveSamples> curves_;
  bool ascending_;
  std::size_t low_, high_;
  Eigen::Index samples_ = 0;
};

struct Found {
  double j = std::numeric_limits<double>::infinity();
  Eigen::VectorXd at;
};

Found descend(const Direction& direction) {
  ElamModel model = direction.model();
  Eigen::VectorXd at = direction.start();
  Eigen::VectorXd off = direction.residuals(at, model);
  Found found{off.squaredNorm(), at};
  Eigen::MatrixXd slopes(direction.samples(), at.size());
  double damping = 1e-3;
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Eigen::VectorXd moved = at;
      const double by = at[k] > 0.5 ? -kDifference : kDifference;  // inside the bounds
      moved[k] += by;
      slopes.col(k) = (direction.residuals(moved, model) - off) / by;
    }
    const Eigen::MatrixXd normal = gram_of(slopes);
    const Eigen::VectorXd along = slopes.transpose() * off;
    const double before = found.j;
    while (damping < 1e6) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * (normal.diagonal().array() + 1e-9 * normal.diagonal().maxCoeff()).matrix();
      const Eigen::VectorXd tried = direction.clipped(at - solve(damped, along));
      if (!tried.allFinite()) break;
      const Eigen::VectorXd there = direction.residuals(tried, model);
      if (there.squaredNorm() < found.j) {
        found = {there.squaredNorm(), tried};
        at = tried;
        off = there;
        damping = std::max(damping * 0.1, 1e-9);
        break;
      }
      damping *= 8.0;
    }
    if (before - found.j <= kSettled * before) break;
  }
  return found;
}

}  // namespace

ElamPieces fit_pieces(ElamModel& model, const ElamSamples& samples, int splits) {
  ElamPieces pieces;
  const auto more = static_cast<std::size_t>(splits - 1);
  for (const bool ascending : {false, true}) {
    const std::vector<CurveSamples>& curves = ascending ? samples.ascending : samples.descending;
    const ElamModel start = model;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t low = 0; low <= more; ++low) {
      const Direction direction(start, curves, ascending, low, more - low);
      const Found found = descend(direction);
      if (found.j >= least) continue;
      least = found.j;
      direction.put(found.at, model, pieces);
    }
  }
  return pieces;
}

}  // namespace tactbench::analysis
