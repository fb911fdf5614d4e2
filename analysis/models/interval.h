// The interval of a grid that holds a place: the one cast from a number to an index of a table.
#pragma once

#include <algorithm>
#include <cstddef>

namespace tactbench::analysis {

// Of n intervals of length 1 from 0 on; beyond them the nearest, for what is no number the first.
template <class Real>
std::size_t interval_of(Real at, std::size_t n) {
  return static_cast<std::size_t>(std::min(std::max(Real(0), at), static_cast<Real>(n - 1)));
}

}  // namespace tactbench::analysis
