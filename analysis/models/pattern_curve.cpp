#include "analysis/models/pattern_curve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/models/model.h"

namespace tactbench::analysis {
namespace {

constexpr double kMinimumSlope = 1e-9;  // of span over span [A11]

// Pool-adjacent-violators, equal weights: the non-decreasing sequence nearest to `z` in least squares.
void pool_adjacent_violators(std::span<double> z) {
  struct Block {
    double mean;
    std::size_t count;
  };
  std::vector<Block> blocks;
  for (const double value : z) {
    blocks.push_back({value, 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean > blocks.back().mean) {
      const Block last = blocks.back();
      blocks.pop_back();
      Block& into = blocks.back();
      const std::size_t count = into.count + last.count;
      into.mean = (into.mean * static_cast<double>(into.count) + last.mean * static_cast<double>(last.count)) /
                  static_cast<double>(count);
      into.count = count;
    }
  }
  std::size_t i = 0;
  for (const Block& block : blocks)
    for (std::size_t k = 0; k < block.count; ++k) z[i++] = block.mean;
}

}  // namespace

PatternCurve::PatternCurve(std::span<const double> x, std::span<const double> y, double y_first, double y_last)
    : x_(x.begin(), x.end()), y_(y.begin(), y.end()) {
  if (x.size() < 2 || x.size() != y.size()) throw std::invalid_argument("pattern curve: fewer than two knots");
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(x_, finite) || !std::ranges::all_of(y_, finite) || !finite(y_first) || !finite(y_last))
    throw std::invalid_argument("pattern curve: a knot is not a finite number");
  for (std::size_t i = 1; i < x_.size(); ++i)
    if (x_[i] <= x_[i - 1]) throw std::invalid_argument("pattern curve: pressures do not increase");
  if (y_last <= y_first) throw std::invalid_argument("pattern curve: the output does not rise with pressure");

  const double minimum = kMinimumSlope * (y_last - y_first) / (x_.back() - x_.front());
  y_.front() = y_first;
  y_.back() = y_last;
  bool increasing = true;
  // Half the minimum: a curve that went through here before is taken unchanged, to its last bits.
  for (std::size_t i = 1; i < y_.size(); ++i)
    increasing = increasing && y_[i] - y_[i - 1] >= 0.5 * minimum * (x_[i] - x_[i - 1]) && y_[i] > y_[i - 1];
  if (increasing) return;

  // Slope >= minimum is "z = y - minimum x does not fall"; pinned ends are bounds on what lies between.
  for (std::size_t i = 0; i < y_.size(); ++i) y_[i] -= minimum * (x_[i] - x_.front());
  const double low = y_.front(), high = y_.back();
  pool_adjacent_violators(std::span(y_).subspan(1, y_.size() - 2));
  for (std::size_t i = 1; i + 1 < y_.size(); ++i) y_[i] = std::clamp(y_[i], low, high) + minimum * (x_[i] - x_.front());
  y_.back() = y_last;
  for (std::size_t i = 1; i < y_.size(); ++i)
    if (y_[i] <= y_[i - 1]) throw std::invalid_argument("pattern curve: knots too close to be distinguished");
}

std::size_t PatternCurve::segment(double x) const {
  // Grids are uniform or nearly so: the proportional guess is right or one off.
  const std::size_t last = x_.size() - 2;
  const double share = (x - x_.front()) / (x_.back() - x_.front());
  std::size_t i = interval_of(share * static_cast<double>(last + 1), last + 1);
  while (i > 0 && x < x_[i]) --i;
  while (i < last && x >= x_[i + 1]) ++i;
  return i;
}

double PatternCurve::operator()(double x) const {
  if (x <= x_.front()) return y_.front();
  if (x >= x_.back()) return y_.back();
  const std::size_t i = segment(x);
  return y_[i] + (y_[i + 1] - y_[i]) * ((x - x_[i]) / (x_[i + 1] - x_[i]));
}

double PatternCurve::inverse(double y) const {
  if (y <= y_.front()) return x_.front();
  if (y >= y_.back()) return x_.back();
  return piece(y).along(y);
}

// Halving without branches: outputs carry noise, so branches on them could not be predicted.
CurvePiece PatternCurve::piece(double y) const {
  const double* first = y_.data();
  for (std::size_t left = y_.size() - 1; left > 1;) {
    const std::size_t half = left / 2;
    first = first[half] <= y ? first + half : first;
    left -= half;
  }
  const auto i = static_cast<std::size_t>(first - y_.data());
  return {y_[i], y_[i + 1], y_[i], x_[i], (x_[i + 1] - x_[i]) / (y_[i + 1] - y_[i])};
}

double PatternCurve::slope(double x) const {
  const std::size_t i = segment(std::clamp(x, x_.front(), x_.back()));
  return (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]);
}

PatternCurve curve_from(const ModelSource& source, const std::string& outputs) {
  const std::vector<double> x = source.numbers("x"), y = source.numbers(outputs);
  if (y.empty() || y.size() != x.size())
    throw std::invalid_argument("model: \"" + outputs + "\" does not hold a number for each of \"x\"");
  return {x, y, y.front(), y.back()};
}

}  // namespace tactbench::analysis
