// Comparison of numbers with expected ones where NaN equals NaN.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace tactbench::analysis {

inline void check_alike(const std::vector<double>& found, const std::vector<double>& expected, double margin = 0.0) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("place " << i);
    if (std::isnan(expected[i]))
      CHECK(std::isnan(found[i]));
    else
      CHECK(found[i] == Approx(expected[i]).margin(margin));
  }
}

}  // namespace tactbench::analysis
