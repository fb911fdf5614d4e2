// The report's U against the truth, each condition that it is stated for within 93 to 98 %.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "bench/benchmarks/coverage.h"
#include "tests/support/paths.h"

namespace tactbench::tests {

// Each condition that U is stated for. `stated`: how many of them have to be, else a report that is valid for nothing
// would pass.
inline void check_coverage(const bench::CoverageOptions& options, std::size_t stated) {
  const TemporaryFolder folder;
  const std::vector<bench::Figure> figures = bench::benchmark_coverage(options, folder.path());
  const auto value = [&](const std::string& name) {
    return std::ranges::find(figures, name, &bench::Figure::name)->value;
  };
  std::size_t counted = 0;
  for (const bench::Figure& figure : figures) {
    if (figure.unit != "%") continue;
    CAPTURE(figure.name, figure.value, value(figure.name + "_median_u"), value(figure.name + "_half_width_95"));
    CHECK(figure.value >= 93.0);
    CHECK(figure.value <= 98.0);
    CHECK(value(figure.name + "_median_u") <= 1.3 * value(figure.name + "_half_width_95"));
    ++counted;
  }
  CHECK(counted >= stated);
}

}  // namespace tactbench::tests
