// What `benchmark identify` identifies. Not a unit test: histories are made by several threads.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/benchmarks/identify.h"
#include "bench/benchmarks/synthetic_array.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("benchmark identify: each taxel's branches end where they turn, and the mean of the taxels is none") {
  const std::vector<TaxelToIdentify> taxels = taxels_to_identify(synthetic_dataset(1, 2, 1));
  REQUIRE(taxels.size() == 2);
  const std::vector<double> turns{0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0};
  for (std::size_t t = 0; t < 2; ++t) {
    INFO("taxel " << t);
    REQUIRE(taxels[t].data.histories.size() == 2);
    REQUIRE(taxels[t].branches.size() == 12 + 20);
    const analysis::History& descending = taxels[t].data.histories[0];
    REQUIRE(descending.y.size() == 211);
    std::size_t at = 0;
    for (std::size_t b = 0; b < 12; ++b) {
      INFO("branch " << b);
      const analysis::TaxelBranch& branch = taxels[t].branches[b];
      CHECK(branch.ascending == (b % 2 == 0));
      const auto samples = static_cast<std::size_t>(std::abs(turns[b + 1] - turns[b]) / 2.0) + 1;
      REQUIRE(branch.pressure_psi.size() == samples);
      REQUIRE(branch.volts.size() == samples);
      CHECK(branch.volts.front() == descending.y[at]);
      CHECK(branch.pressure_psi.front() == turns[b]);
      at += samples - 1;
      CHECK(branch.volts.back() == descending.y[at]);
      CHECK(branch.pressure_psi.back() == turns[b + 1]);
    }
  }
}
