// A strictly increasing piecewise linear curve and its inverse: the pattern curves P_a and P_d of the paper, section
// 4.1 (linear interpolation of the measured external loop).
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tactbench::analysis {

class ModelSource;

// A linear piece of a model's branch, from outputs to inputs.
// x = x_a + slope (y - y_a) for low <= y <= high.
struct CurvePiece {
  double low = 1.0, high = 0.0, y_a = 0.0, x_a = 0.0, slope = 0.0;  // as made it holds nothing
  [[nodiscard]] bool holds(double y) const { return y >= low && y <= high; }
  [[nodiscard]] double along(double y) const { return x_a + slope * (y - y_a); }
};
// The open end of a constant piece.
inline constexpr double kFarOutput = 1e300;

class PatternCurve {
 public:
  PatternCurve() = default;
  // Knots x strictly increasing, y as measured. Made strictly monotone by pool-adjacent-violators with a minimum slope
  // of 1e-9 of the span [A11]; the ends are pinned to y_first and y_last. Knots that comply already are kept bit for
  // bit. Throws std::invalid_argument when fewer than two knots, not finite, or y_last <= y_first.
  PatternCurve(std::span<const double> x, std::span<const double> y, double y_first, double y_last);

  [[nodiscard]] double operator()(double x) const;  // clamped to the ends
  [[nodiscard]] double inverse(double y) const;     // clamped to the ends
  [[nodiscard]] CurvePiece piece(double y) const;   // of the inverse, between the two knots around y
  [[nodiscard]] double slope(double x) const;       // of the segment that holds x (the right one at a knot)
  [[nodiscard]] std::span<const double> x() const { return x_; }
  [[nodiscard]] std::span<const double> y() const { return y_; }

 private:
  [[nodiscard]] std::size_t segment(double x) const;
  std::vector<double> x_, y_;
};

// Through a model's member "x" and that of its outputs. Throws std::invalid_argument.
PatternCurve curve_from(const ModelSource& source, const std::string& outputs);

// Index of the grid interval that contains a coordinate; always an index of the table, for any number.
// Of n intervals of length 1 starting at 0; outside the nearest one, for NaN the first.
template <class Real>
std::size_t interval_of(Real at, std::size_t n) {
  return static_cast<std::size_t>(std::min(std::max(Real(0), at), static_cast<Real>(n - 1)));
}

}  // namespace tactbench::analysis
