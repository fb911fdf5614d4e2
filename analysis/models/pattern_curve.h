// A strictly increasing piecewise linear curve and its inverse: the pattern curves P_a and P_d of the paper, section
// 4.1 (linear interpolation of the measured external loop).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "analysis/models/piece.h"

namespace tactbench::analysis {

class ModelSource;

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

}  // namespace tactbench::analysis
