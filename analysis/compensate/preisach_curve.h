// Preisach's model as a curve of the compensator: Everett's function at grid points, its branches' linear pieces, and
// the staircase of turning points. Inside, inputs count in intervals of the grid, from 0 to n, and outputs are u, with
// the readout's divider undone.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "analysis/models/divider.h"
#include "analysis/models/interval.h"
#include "analysis/models/piece.h"

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
  explicit PreisachCurve(std::shared_ptr<const Film> film)
      : film_(std::move(film)), per_interval_((film_->x_high - film_->x_low) / static_cast<double>(film_->n)) {}

  [[nodiscard]] double top() const { return film_->divider.output(film_->top()); }
  [[nodiscard]] double x_low() const { return film_->x_low; }
  [[nodiscard]] double x_high() const { return film_->x_high; }
  [[nodiscard]] double place(double y) const { return film_->divider.linear(y); }
  [[nodiscard]] double stretch(double y) const {
    const double share = 1.0 - std::min(y * film_->divider.per_amplitude, Divider::kMost);
    return 1.0 / (share * share);
  }
  void start(bool from_top) {
    count_ = 1;
    x_[0] = u_[0] = 0.0;
    if (from_top) turn_at(static_cast<double>(film_->n), film_->top());
  }
  void go(double at) { count_ = left_at(at); }
  void turn(double at) { turn_at(piece_in_intervals(at).along(at), at); }
  [[nodiscard]] CurvePiece piece(double at) const {
    CurvePiece piece = piece_in_intervals(at);
    piece.x_a = film_->x_low + per_interval_ * piece.x_a;
    piece.slope *= per_interval_;
    return piece;
  }

 private:
  static constexpr std::uint8_t kMost = 24;  // when full, the last two turning points, the smallest loop, are forgotten

  [[nodiscard]] bool rises() const { return count_ % 2 == 1; }
  // How many corners remain when the present branch goes on to u.
  [[nodiscard]] std::uint8_t left_at(double at) const {
    std::uint8_t left = count_;
    if (rises())
      while (left >= 3 && at > u_[left - 2U]) left = static_cast<std::uint8_t>(left - 2);
    else
      while (left >= 4 && at < u_[left - 2U]) left = static_cast<std::uint8_t>(left - 2);
    return left;
  }
  [[nodiscard]] CurvePiece piece_in_intervals(double at) const;
  void turn_at(double x_turn, double at) {
    go(at);
    if (!rises() && x_turn <= 0.0) {
      count_ = 1;
      return;
    }
    if (count_ == kMost) count_ = static_cast<std::uint8_t>(count_ - 2);
    x_[count_] = x_turn;
    u_[count_] = at;
    ++count_;
  }

  std::shared_ptr<const Film> film_;
  double per_interval_;
  // Turning points, minima even and maxima odd, the first the low end; the branch since the last is the present one.
  std::array<double, kMost> x_{}, u_{};
  std::uint8_t count_ = 1;
};

}  // namespace tactbench::analysis
