// Preisach's weights by non-negative least squares: one Gram matrix for all taxels.
#include <Eigen/Core>
#include <algorithm>

#include "analysis/identify/fit_samples.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/models/play_operators.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kCellRows = 30;  // 465 cells; the paper's grid of 2 psi
constexpr std::size_t kCells = kCellRows * (kCellRows + 1) / 2;

struct CellState {
  double x_low, span;
  std::vector<double> on = std::vector<double>(kCells, 0.0);  // share of each cell that is switched on
  // The shares after going to x without a turn.
  void moved(double x, double* now) const {
    const double at = (x - x_low) / span * static_cast<double>(kCellRows);
    std::array<double, kCellRows> share;
    for (std::size_t i = 0; i < kCellRows; ++i) share[i] = std::clamp(at - static_cast<double>(i), 0.0, 1.0);
    for (std::size_t i = 0, cell = 0; i < kCellRows; ++i)
      for (std::size_t j = 0; j <= i; ++j, ++cell) now[cell] = generalized_play(share[i], share[j], 0.0, on[cell]);
  }
  void move(double x) { moved(x, on.data()); }
};

class PreisachIdentifier final : public Identifier {
 public:
  explicit PreisachIdentifier(const FitData& like) : samples_(like) {
    cells_.resize(kCells, static_cast<Eigen::Index>(samples_.fitted.size()));
    Eigen::Index row = 0;
    const CellState virgin{samples_.x_low, samples_.x_high - samples_.x_low};
    walk_branches(samples_, virgin, [&](std::size_t i, const CellState& state) {
      if (row < cells_.cols() && samples_.fitted[static_cast<std::size_t>(row)] == i)
        state.moved(samples_.x[i], cells_.col(row++).data());
    });
    gram_ = Eigen::MatrixXd::Zero(kCells, kCells);
    gram_.selfadjointView<Eigen::Lower>().rankUpdate(cells_);
    gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
  }

  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front();
    Eigen::VectorXd target(cells_.cols());
    for (Eigen::Index r = 0; r < target.size(); ++r)
      target[r] = y[samples_.fitted[static_cast<std::size_t>(r)]] - y_low;
    const Eigen::VectorXd weights = non_negative_least_squares(gram_, cells_ * target);
    ModelFit fit;
    fit.model = std::make_unique<PreisachModel>(samples_.x_low, samples_.x_high, y_low,
                                                std::vector<double>(weights.begin(), weights.end()));
    score_walk(fit, data, samples_, y, true);
    return fit;
  }

 private:
  FitSamples samples_;
  Eigen::MatrixXd cells_;  // a column a sample
  Eigen::MatrixXd gram_;
};

}  // namespace

std::unique_ptr<Identifier> prepare_preisach(const FitData& like, const IdentifyOptions& /*options*/) {
  return std::make_unique<PreisachIdentifier>(like);
}

}  // namespace tactbench::analysis
