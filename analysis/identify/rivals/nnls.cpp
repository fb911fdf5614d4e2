#include "analysis/identify/rivals/nnls.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactbench::analysis {
namespace {

constexpr double kSame = 1e-10;  // what is new in a column, of its square
constexpr double kFlat = 1e-10;  // a gradient, of the largest at the start

// The columns that are not held at 0, and Cholesky's factor of their Gram matrix, grown by one row a column; with it
// the right side, solved forward.
class Free {
 public:
  Free(const Eigen::MatrixXd& gram, const Eigen::VectorXd& along)
      : gram_(gram), along_(along), factor_(gram.rows(), gram.rows()), solved_(gram.rows()) {}
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(columns_.size()); }
  [[nodiscard]] Eigen::Index column(Eigen::Index k) const { return columns_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] bool add(Eigen::Index column) {
    const Eigen::Index k = size();
    Eigen::VectorXd row(k);
    for (Eigen::Index i = 0; i < k; ++i) row[i] = gram_(this->column(i), column);
    forward(row);
    const double rest = gram_(column, column) - row.squaredNorm();
    if (rest <= kSame * gram_(column, column)) return false;
    factor_.row(k).head(k) = row.transpose();
    factor_(k, k) = std::sqrt(rest);
    solved_[k] = (along_[column] - row.dot(solved_.head(k))) / factor_(k, k);
    columns_.push_back(column);
    return true;
  }
  template <class Drop>
  void drop(const Drop& dropped) {
    const std::vector<Eigen::Index> before = std::move(columns_);
    columns_.clear();
    std::size_t k = 0;
    while (!dropped(before[k])) columns_.push_back(before[k++]);  // the factor up to the first stays
    for (; k < before.size(); ++k)
      if (!dropped(before[k])) static_cast<void>(add(before[k]));
  }
  [[nodiscard]] Eigen::VectorXd solve() const {
    Eigen::VectorXd z = solved_.head(size());
    for (Eigen::Index k = size(); k-- > 0;) {
      const Eigen::Index below = size() - k - 1;
      z[k] = (z[k] - factor_.col(k).segment(k + 1, below).dot(z.tail(below))) / factor_(k, k);
    }
    return z;
  }

 private:
  void forward(Eigen::VectorXd& z) const {
    for (Eigen::Index k = 0; k < size(); ++k) {
      const Eigen::Index below = size() - k - 1;
      z[k] /= factor_(k, k);
      z.tail(below) -= z[k] * factor_.col(k).segment(k + 1, below);
    }
  }
  const Eigen::MatrixXd& gram_;
  const Eigen::VectorXd& along_;
  Eigen::MatrixXd factor_;
  Eigen::VectorXd solved_;
  std::vector<Eigen::Index> columns_;
};

}  // namespace

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& along) {
  const Eigen::Index n = gram.rows();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n), gradient = along;
  const double flat = kFlat * along.cwiseAbs().maxCoeff();
  std::vector<bool> out(static_cast<std::size_t>(n), false);  // free, or not to be tried now
  Free free(gram, along);
  for (Eigen::Index entered = 0; entered < 3 * n; ++entered) {
    Eigen::Index best = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (!out[static_cast<std::size_t>(j)] && gradient[j] > flat && (best < 0 || gradient[j] > gradient[best]))
        best = j;
    if (best < 0) break;
    out[static_cast<std::size_t>(best)] = true;
    if (!free.add(best)) continue;
    Eigen::VectorXd z = free.solve();
    // As far towards the unconstrained minimum as no value turns negative; those that meet 0 stay there.
    while (free.size() > 0 && z.minCoeff() <= 0.0) {
      double share = 1.0;
      for (Eigen::Index k = 0; k < free.size(); ++k)
        if (const double at = x[free.column(k)]; z[k] <= 0.0) share = std::min(share, at / (at - z[k]));
      for (Eigen::Index k = 0; k < free.size(); ++k) {
        double& at = x[free.column(k)];
        const double to = at + share * (z[k] - at);
        at = z[k] <= 0.0 && to <= 1e-14 * (at - z[k]) ? 0.0 : std::max(to, 0.0);
      }
      const auto met = [&](Eigen::Index column) { return x[column] == 0.0; };
      for (Eigen::Index k = 0; k < free.size(); ++k)
        if (met(free.column(k))) out[static_cast<std::size_t>(free.column(k))] = false;
      free.drop(met);
      z = free.solve();
    }
    if (x[best] == 0.0 && free.size() == 0) break;
    gradient = along;
    for (Eigen::Index k = 0; k < free.size(); ++k) {
      x[free.column(k)] = z[k];
      gradient -= z[k] * gram.col(free.column(k));
    }
  }
  return x;
}

}  // namespace tactbench::analysis
