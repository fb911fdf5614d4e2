// Figures of `benchmark charts` as they were recorded, in the order in which they are printed.
#pragma once

#include <catch2/catch.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/benchmarks/charts.h"

namespace tactbench::tests {

struct RecordedChart {
  const char* name;
  double of_8, of_20, of_30;  // baselines of so many runs
};

inline void check_charts(const std::vector<bench::Figure>& figures, std::span<const RecordedChart> recorded) {
  REQUIRE(figures.size() == 3 * recorded.size());
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const std::size_t n = i / recorded.size();
    const RecordedChart& was = recorded[i % recorded.size()];
    CHECK(figures[i].name == std::string("charts_n") + (n == 0 ? "8_" : n == 1 ? "20_" : "30_") + was.name);
    INFO(figures[i].name);
    CHECK(figures[i].value == Approx(n == 0 ? was.of_8 : n == 1 ? was.of_20 : was.of_30).margin(1e-3));
    CHECK(figures[i].unit == (figures[i].name.ends_with("_median") ? "runs" : "%"));
  }
}

}  // namespace tactbench::tests
