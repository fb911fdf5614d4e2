// The numeric inverse of all models for which the paper gives none.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace tactbench::analysis {

// The first input at which `output` takes the value y on the way from knots.front() through the others in order
// (rising or falling). `output` is continuous and monotone between neighbouring knots; where it is monotone throughout,
// two knots suffice. When y is not reached: the first knot whose output is nearest to y. Bisection down to neighbouring
// numbers, at most 54 evaluations a piece: the output is then met to its slope times 2^-53 of the input.
template <class Output>
double first_crossing(const Output& output, std::span<const double> knots, double y) {
  double from = knots.front(), from_y = output(from);
  double nearest = from, nearest_off = std::abs(from_y - y);
  for (std::size_t k = 1; k < knots.size(); ++k) {
    const double to = knots[k], to_y = output(to);
    if (std::min(from_y, to_y) <= y && y <= std::max(from_y, to_y)) {
      const auto taken = [&, rising = to_y > from_y](double x) { return rising ? output(x) >= y : output(x) <= y; };
      if (taken(from)) return from;
      double before = from, at = to;
      const double enough = 0.5 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to));
      while (std::abs(at - before) > enough) {
        const double middle = before + 0.5 * (at - before);
        if (middle == before || middle == at) break;
        (taken(middle) ? at : before) = middle;
      }
      return at;
    }
    if (std::abs(to_y - y) < nearest_off) {
      nearest = to;
      nearest_off = std::abs(to_y - y);
    }
    from = to;
    from_y = to_y;
  }
  return nearest;
}

}  // namespace tactbench::analysis
