// POLY is linear least squares, five unknowns a direction [A2]: F(t) = t + t (1 - t) (sum of e_k P_k(2 t - 1)), P_k
// Legendre's polynomials, so that the ends are met and the normal equations are well conditioned. Each branch's Gram
// matrix depends on the inputs alone; the outputs only weigh it with the square of the branch's height.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/models/poly.h"

namespace tactbench::analysis {
namespace {

constexpr int kFree = 5;
constexpr int kPolyPasses = 4;
using FreeValues = Eigen::Matrix<double, kFree, 1>;
// P_k(2 t - 1) in powers of t.
constexpr double kLegendre[kFree][kFree] = {
    {1, 0, 0, 0, 0}, {-1, 2, 0, 0, 0}, {1, -6, 6, 0, 0}, {-1, 12, -30, 20, 0}, {1, -20, 90, -140, 70}};

FreeValues bubbles(double t) {
  FreeValues values;
  for (int k = 0; k < kFree; ++k) {
    double sum = 0.0;
    for (int power = k; power >= 0; --power) sum = sum * t + kLegendre[k][power];
    values[k] = t * (1.0 - t) * sum;
  }
  return values;
}

// a or b of the paper: of (x - x_low)^(6 - i), f(x_low) = y_low, f(x_high) = y_high.
std::array<double, kPolyOrder + 1> polynomial(const FreeValues& e, double span, double y_low, double y_high) {
  std::array<double, kPolyOrder + 1> c{};  // of t^k
  c[1] = 1.0;
  for (int k = 0; k < kFree; ++k)
    for (int power = 0; power <= k; ++power) {
      const auto p = static_cast<std::size_t>(power);
      c[p + 1] += e[k] * kLegendre[k][power];
      c[p + 2] -= e[k] * kLegendre[k][power];
    }
  std::array<double, kPolyOrder + 1> f{};
  double unit = y_high - y_low;
  for (std::size_t k = 1; k <= kPolyOrder; ++k) f[kPolyOrder - k] = c[k] * (unit /= span);
  f[kPolyOrder] = y_low;
  return f;
}

// Branches of one direction from one starting point: their samples at one share are one row.
struct Curve {
  bool ascending = true;
  bool whole = false;     // along the whole range: from (x0, y0) or (xu, yu) instead of a branch's own start
  std::size_t first = 0;  // sample at which it starts
  Eigen::Index begin = 0, end = 0;
  Eigen::Matrix<double, kFree, kFree> gram = Eigen::Matrix<double, kFree, kFree>::Zero();
};

class PolyIdentifier final : public Identifier {
 public:
  PolyIdentifier(const FitData& like, bool free_run)
      : samples_(like), free_run_(free_run), row_(samples_.fitted.size()) {
    // Rising branches first: each direction is one block of rows, the whole curve at its head.
    std::vector<double> shares, counts;
    for (const bool ascending : {true, false}) {
      std::map<double, Eigen::Index> rows;
      curves_.push_back({ascending, true, 0, static_cast<Eigen::Index>(shares.size())});
      for (const bool whole : {true, false}) {
        for (const FitSamples::Part& part : samples_.parts) {
          if (part.ascending != ascending || is_whole(part) != whole) continue;
          if (!whole) rows.clear();
          if (!whole) curves_.push_back({ascending, false, part.first, static_cast<Eigen::Index>(shares.size())});
          add(part, whole, rows, shares, counts);
          curves_.back().end = static_cast<Eigen::Index>(shares.size());
        }
        if (whole) curves_.back().end = static_cast<Eigen::Index>(shares.size());
      }
      if (ascending) falling_ = static_cast<Eigen::Index>(shares.size());
    }
    share_ = Eigen::Map<const Eigen::VectorXd>(shares.data(), static_cast<Eigen::Index>(shares.size()));
    count_ = Eigen::Map<const Eigen::VectorXd>(counts.data(), share_.size());
    bubbles_.resize(share_.size(), kFree);
    for (Eigen::Index r = 0; r < share_.size(); ++r) bubbles_.row(r) = bubbles(share_[r]).transpose();
    for (Curve& curve : curves_) {
      const auto own = bubbles_.middleRows(curve.begin, curve.end - curve.begin);
      curve.gram = own.transpose() * count_.segment(curve.begin, own.rows()).asDiagonal() * own;
    }
    plain_ = plain_ && !free_run && samples_.fitted.size() == samples_.scored.size();
  }

  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    ModelFit best = fit_from(data, y, y);
    // Free run: the branches' starts are the model's own. Each pass takes them from the model of the one before.
    ModelFit last;
    for (int pass = 0; free_run_ && pass < kPolyPasses; ++pass) {
      std::vector<double> own;
      for (const History& history : data.histories) {
        const std::vector<double> walked = predict_history(last.model ? *last.model : *best.model, history, true);
        own.insert(own.end(), walked.begin(), walked.end());
      }
      last = fit_from(data, y, own);
      if (last.j < best.j) best = std::exchange(last, {});
    }
    return best;
  }

 private:
  [[nodiscard]] bool is_whole(const FitSamples::Part& part) {
    const double near = kPolyOuterShare * (samples_.x_high - samples_.x_low), x1 = samples_.x[part.first];
    const bool low = x1 - samples_.x_low <= near, high = samples_.x_high - x1 <= near;
    // A free run knows no external branches but those that a history begins on.
    if (free_run_) return part.opens_history && (part.ascending || part.from_top);
    const bool whole = part.ascending ? low : high;
    plain_ = plain_ && (whole || !(low || high));
    return whole;
  }

  void add(const FitSamples::Part& part, bool whole, std::map<double, Eigen::Index>& rows, std::vector<double>& shares,
           std::vector<double>& counts) {
    const double x1 = samples_.x[part.first];
    const double from = part.ascending && !whole ? x1 : samples_.x_low;
    const double to = part.ascending || whole ? samples_.x_high : x1;
    const auto begin = std::ranges::upper_bound(samples_.fitted, part.first);
    for (auto at = begin; at != samples_.fitted.end() && *at <= part.last; ++at) {
      const double share = to > from ? (samples_.x[*at] - from) / (to - from) : 1.0;
      const auto [row, fresh] = rows.try_emplace(share, static_cast<Eigen::Index>(shares.size()));
      if (fresh) shares.push_back(share);
      if (fresh) counts.push_back(0.0);
      counts[static_cast<std::size_t>(row->second)] += 1.0;
      row_[static_cast<std::size_t>(at - samples_.fitted.begin())] = row->second;
    }
  }

  // `starts`: by sample, the ordinates at which branches start.
  [[nodiscard]] ModelFit fit_from(const FitData& data, std::span<const double> y,
                                  std::span<const double> starts) const {
    const double y_low = data.ascending.y().front(), y_high = data.ascending.y().back();
    Eigen::Matrix<double, kFree, kFree> up = decltype(up)::Zero(), down = decltype(down)::Zero();
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(share_.size()), straight(share_.size()), height(share_.size());
    for (std::size_t k = 0; k < row_.size(); ++k) sum[row_[k]] += y[samples_.fitted[k]];
    for (const Curve& curve : curves_) {
      const double turn = !curve.whole ? starts[curve.first] : curve.ascending ? y_low : y_high;
      const double base = curve.ascending ? turn : y_low, rise = curve.ascending ? y_high - turn : turn - y_low;
      (curve.ascending ? up : down) += rise * rise * curve.gram;
      for (Eigen::Index r = curve.begin; r < curve.end; ++r) {
        height[r] = rise;
        straight[r] = base + rise * share_[r];
      }
    }
    const Eigen::VectorXd along = height.cwiseProduct(sum - count_.cwiseProduct(straight));
    const Eigen::Index fall = falling_, falls = share_.size() - falling_;
    const FreeValues e_up = up.ldlt().solve(bubbles_.topRows(fall).transpose() * along.head(fall));
    const FreeValues e_down = down.ldlt().solve(bubbles_.bottomRows(falls).transpose() * along.tail(falls));
    const double span = samples_.x_high - samples_.x_low;
    ModelFit fit;
    fit.model = std::make_unique<PolyModel>(
        PolyParameters{polynomial(e_up, span, y_low, y_high), polynomial(e_down, span, y_low, y_high)}, samples_.x_low,
        samples_.x_high, y_low, y_high);
    if (!plain_) {
      score_walk(fit, data, samples_, y, free_run_);
      return fit;
    }
    Eigen::VectorXd& model = sum;
    model.head(fall).noalias() = bubbles_.topRows(fall) * e_up;
    model.tail(falls).noalias() = bubbles_.bottomRows(falls) * e_down;
    model = straight + height.cwiseProduct(model);
    Eigen::VectorXd errors(static_cast<Eigen::Index>(row_.size()));
    for (std::size_t k = 0; k < row_.size(); ++k)
      errors[static_cast<Eigen::Index>(k)] = model[row_[k]] - y[samples_.fitted[k]];
    score(fit, data, {errors.data(), row_.size()});
    return fit;
  }

  FitSamples samples_;
  bool free_run_;
  bool plain_ = true;  // the regression's own residuals are the model's
  std::vector<Curve> curves_;
  std::vector<Eigen::Index> row_;  // of each fitted sample
  Eigen::VectorXd share_, count_;  // t of each row, its samples
  Eigen::Matrix<double, Eigen::Dynamic, kFree> bubbles_;
  Eigen::Index falling_ = 0;  // first row of a falling branch
};

}  // namespace

std::unique_ptr<Identifier> PolyModel::prepare(const FitData& like, const IdentifyOptions& options) {
  return std::make_unique<PolyIdentifier>(like, options.free_run);
}

KnownModel PolyModel::known() {
  constexpr double kSpanPsi = 60.0, kTopV = 3.49;
  const std::array<double, 6> up{1.6, -1.0, 0.5, -0.2, 0.06, 0.04}, down{2.2, -1.9, 0.6, 0.2, -0.1, 0.0};
  PolyParameters parameters;
  for (std::size_t k = 0; k < kPolyOrder; ++k) {
    const double power = std::pow(kSpanPsi, static_cast<double>(k + 1));
    parameters.a[kPolyOrder - 1 - k] = kTopV * up[k] / power;
    parameters.b[kPolyOrder - 1 - k] = kTopV * down[k] / power;
  }
  return {std::make_unique<PolyModel>(parameters, 0.0, kSpanPsi, 0.0, kTopV),
          {0.0, 2.102725, 3.49, 2.47571875, 1.10566036522634, 2.74754486831276}};
}

}  // namespace tactbench::analysis
