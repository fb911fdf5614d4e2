// MPI is linear but for tau, and the regressors depend on the inputs alone: the cubic is eliminated once for all
// taxels, what is left of J is a quotient of two forms in the densities, searched over tau.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/models/mpi.h"

namespace tactbench::analysis {
namespace {

// The first operator has r = 0 and is the input itself: a1 takes it in.
constexpr int kPlays = kMpiOperators - 1;
constexpr int kThresholdGrid = 65;
constexpr int kNarrowings = 30;  // golden sections: tau to 2e-7, J to its square
using Plays = Eigen::Matrix<double, kPlays, 1>;

struct PlayState {
  double x_low, span;
  MpiModel::Operators operators{};
  [[nodiscard]] double share(double x) const { return (x - x_low) / span; }
  void move(double x) { operators = MpiModel::moved(operators, share(x)); }
};

// e^(-tau k^2), k = 0..8, the largest 1: they span a hundred orders of magnitude at the ends of tau's range.
Plays shape_of(double tau) {
  const double by = std::exp(-tau), by_two = by * by;
  Plays shape;
  double value = 1.0, ratio = by;
  for (int k = 0; k < kPlays; ++k) {
    shape[k] = value;
    value *= ratio;
    ratio *= by_two;
  }
  return shape / std::max(shape[0], shape[kPlays - 1]);
}

double tau_at(int k) { return -kMpiTau + 2.0 * kMpiTau * k / (kThresholdGrid - 1); }

class MpiIdentifier final : public Identifier {
 public:
  explicit MpiIdentifier(const FitData& like) : samples_(like) {
    const PlayState virgin{samples_.x_low, samples_.x_high - samples_.x_low};
    cubic_.resize(static_cast<Eigen::Index>(samples_.fitted.size()), 3);
    plays_.resize(cubic_.rows(), kPlays);
    Eigen::Index row = 0;
    walk_branches(samples_, virgin, [&](std::size_t i, const PlayState& state) {
      if (row == cubic_.rows() || samples_.fitted[static_cast<std::size_t>(row)] != i) return;
      const double u = state.share(samples_.x[i]);
      const MpiModel::Operators now = MpiModel::moved(state.operators, u);
      cubic_.row(row) << u, u * u, u * u * u;
      plays_.row(row++) = Eigen::Map<const Plays>(now.data() + 1).transpose();
    });
    gram_.compute(cubic_.transpose() * cubic_);
    cross_ = cubic_.transpose() * plays_;
    rest_ = plays_.transpose() * plays_ - cross_.transpose() * gram_.solve(cross_);
    for (int k = 0; k < kThresholdGrid; ++k) grid_.col(k) = shape_of(tau_at(k));
    for (int k = 0; k < kThresholdGrid; ++k) grid_norm_[k] = grid_.col(k).dot(rest_ * grid_.col(k));
  }

  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front();
    Eigen::VectorXd target(cubic_.rows());
    for (Eigen::Index r = 0; r < target.size(); ++r)
      target[r] = y[samples_.fitted[static_cast<std::size_t>(r)]] - y_low;
    const Eigen::Vector3d on_cubic = cubic_.transpose() * target;
    const Plays on_plays = plays_.transpose() * target - cross_.transpose() * gram_.solve(on_cubic);

    const double tau = best_tau(on_plays);
    const Plays shape = shape_of(tau);
    const double norm = shape.dot(rest_ * shape);
    const double height = norm > 0.0 ? std::max(0.0, shape.dot(on_plays)) / norm : 0.0;
    const Eigen::Vector3d c = gram_.solve(on_cubic - height * (cross_ * shape));

    const double span = samples_.x_high - samples_.x_low;
    const MpiModel::Operators density = MpiModel::densities(tau);
    const double rho = height * shape[0] / density[1], first = rho * density[0];
    ModelFit fit;
    fit.model = std::make_unique<MpiModel>(
        MpiParameters{(c[0] - first) / span, c[1] / (span * span), c[2] / (span * span * span), rho, tau},
        samples_.x_low, samples_.x_high, y_low);
    if (samples_.fitted.size() < samples_.scored.size()) {
      score_walk(fit, data, samples_, y, true);
      return fit;
    }
    const Eigen::VectorXd errors = cubic_ * c + plays_ * (height * shape) - target;
    score(fit, data, {errors.data(), static_cast<std::size_t>(errors.size())});
    return fit;
  }

 private:
  // What J falls by when operators of this density join the cubic.
  static double gain(double along, double norm) { return along > 0.0 && norm > 0.0 ? along * along / norm : 0.0; }

  [[nodiscard]] double best_tau(const Plays& on_plays) const {
    const Eigen::Matrix<double, kThresholdGrid, 1> along = grid_.transpose() * on_plays;
    std::array<double, kThresholdGrid> gains{};
    for (int k = 0; k < kThresholdGrid; ++k) gains[static_cast<std::size_t>(k)] = gain(along[k], grid_norm_[k]);
    const auto best = static_cast<int>(std::ranges::max_element(gains) - gains.begin());
    if (gains[static_cast<std::size_t>(best)] == 0.0) return 0.0;
    const auto at = [&](double tau) {
      const Plays shape = shape_of(tau);
      return gain(shape.dot(on_plays), shape.dot(rest_ * shape));
    };
    constexpr double kGolden = 0.6180339887498949;
    double low = tau_at(std::max(best - 1, 0)), high = tau_at(std::min(best + 1, kThresholdGrid - 1));
    double a = high - kGolden * (high - low), b = low + kGolden * (high - low), at_a = at(a), at_b = at(b);
    for (int n = 0; n < kNarrowings; ++n) {
      if (at_a > at_b) {
        high = b;
        b = a;
        at_b = at_a;
        at_a = at(a = high - kGolden * (high - low));
      } else {
        low = a;
        a = b;
        at_a = at_b;
        at_b = at(b = low + kGolden * (high - low));
      }
    }
    // The ends of tau's range are candidates that the sections only come near to.
    const double inner = 0.5 * (low + high), end = tau_at(best);
    return at(end) >= at(inner) ? end : inner;
  }

  FitSamples samples_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> cubic_;
  Eigen::Matrix<double, Eigen::Dynamic, kPlays> plays_;
  Eigen::LDLT<Eigen::Matrix3d> gram_;
  Eigen::Matrix<double, 3, kPlays> cross_;
  Eigen::Matrix<double, kPlays, kPlays> rest_;  // the plays' Gram matrix without what a cubic explains
  Eigen::Matrix<double, kPlays, kThresholdGrid> grid_;
  Eigen::Matrix<double, kThresholdGrid, 1> grid_norm_;
};

}  // namespace

std::unique_ptr<Identifier> MpiModel::prepare(const FitData& like, const IdentifyOptions& /*options*/) {
  return std::make_unique<MpiIdentifier>(like);
}

KnownModel MpiModel::known() {
  return {std::make_unique<MpiModel>(MpiParameters{.a1 = 0.1, .a2 = -0.001, .a3 = 5e-6, .rho = 3.0, .tau = 0.7}, 0.0,
                                     60.0, 0.3),
          {0.3, 2.77788416581076, 4.33125876620215, 2.84337460039139, 1.30779153371512, 3.36567569952589}};
}

}  // namespace tactbench::analysis
