// What a taxel's model leaves of the pressure, by level and direction: root mean squares of its stream's errors.
#pragma once

#include <cstddef>
#include <span>

#include "analysis/models/interval.h"

namespace tactbench::analysis {

template <class Value>
struct BinsOf {
  double x_low = 0.0, x_high = 1.0;  // range of the levels, psi
  std::span<const Value> psi = {};   // of equal intervals of it, rising, then falling; empty: not known, 0

  // Index into psi, which is not empty.
  [[nodiscard]] std::size_t place(double x, bool rising) const {
    const std::size_t levels = psi.size() / 2;
    const double at = (x - x_low) / (x_high - x_low) * static_cast<double>(levels);
    const std::size_t level = interval_of(at, levels);
    return rising ? level : levels + level;
  }
  [[nodiscard]] Value at(double x, bool rising) const { return psi.empty() ? Value(0) : psi[place(x, rising)]; }
};
using ResidualBins = BinsOf<double>;

}  // namespace tactbench::analysis
