// Comparison of numbers with expected ones where NaN equals NaN, and how work on invalid input ends.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/error.h"

namespace tactbench::analysis {

inline void check_alike(const std::vector<double>& found, const std::vector<double>& expected, double margin = 0.0,
                        double epsilon = 1e-5) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("place " << i);
    if (std::isnan(expected[i]))
      CHECK(std::isnan(found[i]));
    else
      CHECK(found[i] == Approx(expected[i]).margin(margin).epsilon(epsilon));
  }
}

// The id of the error that ends `work`, which has to say how to mend it; empty where `work` comes to its end. Other
// exceptions pass.
template <class Work>
std::string id_of_refusal(const Work& work) {
  try {
    (void)work();
  } catch (const AnalysisError& error) {
    CHECK_FALSE(error.remedy().empty());
    return error.id();
  }
  return {};
}

// The message about a wrong argument; empty if `work` ends without an error.
template <class Work>
std::string why_invalid(const Work& work) {
  try {
    (void)work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

}  // namespace tactbench::analysis
