// Preisach's weights by non-negative least squares: one Gram matrix for all taxels. External branches alone tell sums
// of rows and columns, and the search would end in any of the many sets of weights that have them: then, and only then,
// a ridge takes the smallest ones.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/models/elam.h"
#include "analysis/models/play_operators.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kMostIntervals = 100;
constexpr double kFlattest = 0.1;  // of the mean slope

constexpr double kRidge = 1e-4;  // of the Gram matrix's mean diagonal

// No branch turns further than an external one's share from the ends of the range. Where a recording begins is no turn.
bool external_only(const FitSamples& samples) {
  const double near = kOuterShare * (samples.x_high - samples.x_low);
  return std::ranges::none_of(samples.parts, [&](const FitSamples::Part& part) {
    const double first = samples.x[part.first];
    if (part.opens_history) return false;
    return part.ascending ? first - samples.x_low > near : samples.x_high - first > near;
  });
}

struct CellState {
  double x_low, span;
  std::size_t rows;
  std::vector<double> on = std::vector<double>(rows * (rows + 1) / 2, 0.0);  // share of each cell that is switched on
  // The shares after going to x without a turn.
  void moved(double x, double* now) const {
    const double at = (x - x_low) / span * static_cast<double>(rows);
    std::array<double, kMostIntervals> share;
    for (std::size_t i = 0; i < rows; ++i) share[i] = std::clamp(at - static_cast<double>(i), 0.0, 1.0);
    for (std::size_t i = 0, cell = 0; i < rows; ++i)
      for (std::size_t j = 0; j <= i; ++j, ++cell) now[cell] = generalized_play(share[i], share[j], 0.0, on[cell]);
  }
  void move(double x) { moved(x, on.data()); }
};

class PreisachIdentifier final : public Identifier {
 public:
  PreisachIdentifier(const FitData& like, std::size_t rows, bool by_input) : samples_(like), by_input_(by_input) {
    const auto count = static_cast<Eigen::Index>(rows * (rows + 1) / 2);
    cells_.resize(count, static_cast<Eigen::Index>(samples_.fitted.size()));
    Eigen::Index row = 0;
    const CellState virgin{samples_.x_low, samples_.x_high - samples_.x_low, rows};
    walk_branches(samples_, virgin, [&](std::size_t i, const CellState& state) {
      if (row < cells_.cols() && samples_.fitted[static_cast<std::size_t>(row)] == i)
        state.moved(samples_.x[i], cells_.col(row++).data());
    });
    find_changes();
    external_only_ = external_only(samples_);
    if (!by_input_) gram_ = gram_of(Eigen::VectorXd::Ones(cells_.cols()));
  }

  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front();
    Eigen::VectorXd target(cells_.cols());
    for (Eigen::Index r = 0; r < target.size(); ++r)
      target[r] = y[samples_.fitted[static_cast<std::size_t>(r)]] - y_low;
    Eigen::VectorXd weights;
    if (by_input_) {
      const Eigen::VectorXd squares = inputs_an_output(y).array().square();
      weights = non_negative_least_squares(gram_of(squares), cells_ * squares.cwiseProduct(target));
    } else {
      weights = non_negative_least_squares(gram_, cells_ * target);
    }
    ModelFit fit;
    if (external_only_) fit.undetermined = {"w"};
    fit.model = std::make_unique<PreisachModel>(samples_.x_low, samples_.x_high, y_low,
                                                std::vector<double>(weights.begin(), weights.end()));
    score_walk(fit, data, samples_, y, true);
    return fit;
  }

 private:
  struct Change {
    Eigen::Index cell;
    double by;
  };

  // Of each sample against the one before; of a branch's first against no cell on.
  void find_changes() {
    std::size_t part = 0, before = samples_.parts.size();
    for (Eigen::Index r = 0; r < cells_.cols(); ++r) {
      const std::size_t i = samples_.fitted[static_cast<std::size_t>(r)];
      while (samples_.parts[part].last < i) ++part;
      first_.push_back(part != before);
      before = part;
      begin_.push_back(changes_.size());
      for (Eigen::Index c = 0; c < cells_.rows(); ++c)
        if (const double by = cells_(c, r) - (first_.back() ? 0.0 : cells_(c, r - 1)); by != 0.0)
          changes_.push_back({c, by});
    }
    begin_.push_back(changes_.size());
  }

  // The sum over samples of weight c c', c being a sample's cells. Along a branch few cells change by d from one sample
  // to the next, and c c' by d (c + before)' / 2 and its transpose, which all samples to the branch's end share.
  [[nodiscard]] Eigen::MatrixXd gram_of(const Eigen::VectorXd& weight) const {
    const Eigen::Index cells = cells_.rows();
    Eigen::MatrixXd half = Eigen::MatrixXd::Zero(cells, cells);
    Eigen::VectorXd both(cells);
    double to_end = 0.0;
    for (Eigen::Index r = cells_.cols(); r-- > 0;) {
      const auto at = static_cast<std::size_t>(r);
      to_end += weight[r];
      both = cells_.col(r);
      if (!first_[at]) both += cells_.col(r - 1);
      for (std::size_t k = begin_[at]; k < begin_[at + 1]; ++k)
        half.col(changes_[k].cell) += (0.5 * to_end * changes_[k].by) * both;
      if (first_[at]) to_end = 0.0;
    }
    Eigen::MatrixXd gram = half + half.transpose();
    if (external_only_) gram.diagonal().array() += kRidge * gram.diagonal().mean();
    return gram;
  }

  // dx / dy at each fitted sample, of its branch; where that is flat no more than of a tenth of the mean slope.
  [[nodiscard]] Eigen::VectorXd inputs_an_output(const std::vector<double>& y) const {
    std::vector<double> slopes(y.size(), 0.0);
    double rise = 0.0, way = 0.0;
    for (const FitSamples::Part& part : samples_.parts)
      for (std::size_t i = part.first; i <= part.last; ++i) {
        const std::size_t a = i > part.first ? i - 1 : i, b = i < part.last ? i + 1 : i;
        const double dx = samples_.x[b] - samples_.x[a], dy = y[b] - y[a];
        slopes[i] = dx != 0.0 ? std::abs(dy / dx) : 0.0;
        rise += std::abs(dy);
        way += std::abs(dx);
      }
    const double least = kFlattest * rise / way;
    Eigen::VectorXd inputs(cells_.cols());
    for (Eigen::Index r = 0; r < inputs.size(); ++r)
      inputs[r] = 1.0 / std::max(slopes[samples_.fitted[static_cast<std::size_t>(r)]], least);
    return inputs;
  }

  FitSamples samples_;
  bool by_input_;
  Eigen::MatrixXd cells_;  // a column a sample
  // What changes from sample to sample: those of sample r from begin_[r] to begin_[r + 1], and whether it opens a
  // branch.
  std::vector<Change> changes_;
  std::vector<std::size_t> begin_;
  std::vector<bool> first_;
  Eigen::MatrixXd gram_;  // of errors that count as outputs
  bool external_only_ = false;
};

}  // namespace

std::unique_ptr<Identifier> PreisachModel::prepare(const FitData& like, const IdentifyOptions& options) {
  if (options.cells < 1 || options.cells > static_cast<int>(kMostIntervals))
    throw std::invalid_argument(
        fmt::format("Preisach: {} intervals; 1 to {} are possible", options.cells, kMostIntervals));
  return std::make_unique<PreisachIdentifier>(like, static_cast<std::size_t>(options.cells), options.by_input);
}

}  // namespace tactbench::analysis
