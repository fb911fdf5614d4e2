// A pattern curve laid out for searches: value and slope in one look-up. Agrees with PatternCurve to rounding; what a
// search finds is scored with the model itself.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

class Knots {
 public:
  explicit Knots(const PatternCurve& curve)
      : x_(curve.x().begin(), curve.x().end()), y_(curve.y().begin(), curve.y().end()) {
    for (std::size_t i = 0; i + 1 < x_.size(); ++i) slope_.push_back((y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]));
    per_psi_ = static_cast<double>(slope_.size()) / (x_.back() - x_.front());
  }

  struct Value {
    double y, slope;
  };
  [[nodiscard]] Value at(double x) const {
    const double place = std::clamp((x - x_.front()) * per_psi_, 0.0, static_cast<double>(slope_.size() - 1));
    auto i = static_cast<std::size_t>(place);
    while (i > 0 && x < x_[i]) --i;
    while (i + 1 < slope_.size() && x >= x_[i + 1]) ++i;
    return {y_[i] + slope_[i] * (x - x_[i]), slope_[i]};
  }
  struct Place {
    double x, slope;
  };
  [[nodiscard]] Place inverse(double y) const {
    const auto above = std::upper_bound(y_.begin() + 1, y_.end() - 1, y);
    const auto i = static_cast<std::size_t>(above - y_.begin()) - 1;
    return {x_[i] + (y - y_[i]) / slope_[i], slope_[i]};
  }

 private:
  std::vector<double> x_, y_, slope_;
  double per_psi_ = 0.0;
};

}  // namespace tactbench::analysis
