// Index of the grid interval that contains a coordinate; always an index of the table, for any number.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tactbench::analysis {

// Of n intervals of length 1 starting at 0; outside the nearest one, for NaN the first.
template <class Real>
std::size_t interval_of(Real at, std::size_t n) {
  return static_cast<std::size_t>(std::min(std::max(Real(0), at), static_cast<Real>(n - 1)));
}

}  // namespace tactbench::analysis
