// Preisach's model as a curve of the compensator: Everett's function at grid points, linear pieces of the branches, and
// the staircase of turning points. Internally, inputs are in grid intervals, from 0 to n, and outputs are u, with the
// readout divider inverted.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "analysis/models/divider.h"
#include "analysis/models/interval.h"
#include "analysis/models/piece.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {

class PreisachCurve {
 public:
  // `everett`: the output's rise from grid point j to i >= j at i (i + 1) / 2 + j, (n + 1) (n + 2) / 2 values.
  struct Film {
    double x_low = 0.0, x_high = 1.0;
    std::size_t n = 0;
    Divider divider;  // zero 0
    std::vector<double> everett;
    [[nodiscard]] double at(std::size_t i, std::size_t j) const { return everett[i * (i + 1) / 2 + j]; }
    [[nodiscard]] double top() const { return at(n, 0); }
  };
  // From a model of the divider's u. Throws std::invalid_argument if the model cannot be used for streaming.
  static std::shared_ptr<const Film> film_of(const PreisachModel& model, const Divider& divider);
  struct Corner {
    double x = 0.0, u = 0.0;
  };
  // The branch that starts at a corner, after the first `below` corners.
  struct Way {
    Corner corner;
    std::size_t below = 0;
    [[nodiscard]] bool rises() const { return below % 2 == 0; }
  };
  explicit PreisachCurve(std::shared_ptr<const Film> film)
      : film_(std::move(film)), per_interval_((film_->x_high - film_->x_low) / static_cast<double>(film_->n)) {}

  [[nodiscard]] double top() const { return film_->divider.output(film_->top()); }
  [[nodiscard]] double x_low() const { return film_->x_low; }
  [[nodiscard]] double x_high() const { return film_->x_high; }
  [[nodiscard]] double place(double y) const { return film_->divider.linear(y); }
  [[nodiscard]] double output(double u) const { return film_->divider.output(u); }
  [[nodiscard]] double stretch(double y) const {
    const double share = 1.0 - std::min(y * film_->divider.per_amplitude, Divider::kMost);
    return per_interval_ / (share * share);
  }
  [[nodiscard]] double input(double x) const { return film_->x_low + per_interval_ * x; }
  void start(bool from_top) {
    last_ = {};
    if (from_top) turn({{static_cast<double>(film_->n), film_->top()}, 1});
  }
  void go(double at) { last_ = branch_at(last_, at); }
  [[nodiscard]] Way back_from(double at, const CurvePiece& on) const {
    const double x = on.along(at);
    const std::size_t below = branch_at(last_, at).below + 1;
    if (below % 2 == 0 && x <= 0.0) return {};
    return {{x, at}, below < kMost ? below : below - 2};
  }
  void turn(const Way& way) {
    corners_[way.below] = way.corner;
    last_ = way;
  }
  [[nodiscard]] CurvePiece piece(double at) const { return piece(last_, at); }
  [[nodiscard]] CurvePiece piece(const Way& way, double at) const;

 private:
  static constexpr std::size_t kMost =
      24;  // when full, the last two turning points, which form the smallest loop, are forgotten

  // The branch that continues at u.
  [[nodiscard]] Way branch_at(Way way, double at) const {
    while (way.below >= (way.rises() ? 2U : 3U) &&
           (way.rises() ? at > corners_[way.below - 1].u : at < corners_[way.below - 1].u))
      way = {corners_[way.below - 2], way.below - 2};
    return way;
  }

  std::shared_ptr<const Film> film_;
  double per_interval_;
  Way last_;  // the present branch
  std::array<Corner, kMost>
      corners_{};  // turning points: even indices minima, odd ones maxima; the first is the low end
};

}  // namespace tactbench::analysis
