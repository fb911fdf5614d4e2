// A linear piece of a model's branch, from outputs to inputs.
#pragma once

namespace tactbench::analysis {

// x = x_a + slope (y - y_a) for low <= y <= high.
struct CurvePiece {
  double low = 1.0, high = 0.0, y_a = 0.0, x_a = 0.0, slope = 0.0;  // as made it holds nothing
  [[nodiscard]] bool holds(double y) const { return y >= low && y <= high; }
  [[nodiscard]] double along(double y) const { return x_a + slope * (y - y_a); }
};
// The open end of a constant piece.
inline constexpr double kFarOutput = 1e300;

}  // namespace tactbench::analysis
