// By command: larger arrays than identify_slow.cpp has, and arrays that nothing was chosen on.

#include "tests/analysis/identify/elam/exhaustive_reference.h"

#include <catch2/catch.hpp>

#include "analysis/identify/fit_models.h"
#include "tests/analysis/support/gpi_reference.h"
#include "tests/analysis/support/specimen_taxels.h"

using namespace exhaustive_comparison;
using namespace synthetic;

// Grid sizes were chosen on the seeds above and others; never on these.
TEST_CASE("identify_elam: finds the optimum of an exhaustive search on seeds that were not used for tuning") {
  for (unsigned seed = 30001; seed <= 30005; ++seed)
    for (const double noise : {0.0015, 0.004, 0.012, 0.030, 0.060})
      for (const double clip : {0.0, 0.5 + 0.09 * (seed % 5)})
        compare({clip > 0.0 ? "fresh, clipped" : "fresh",
                 seed * 131 + static_cast<unsigned>(10000 * noise) + (clip > 0.0 ? 7U : 0U), noise,
                 seed % 2 == 0 ? 0.03 : 0.015, 1.0 + seed % 3, clip, 1 + static_cast<int>(seed % 2),
                 seed % 3 == 0   ? 1
                 : seed % 3 == 1 ? 5
                                 : 2},
                1);
}

TEST_CASE("identify_elam: finds the optimum of an exhaustive search on larger arrays") {
  for (const Kind& kind : kKinds) compare(kind, 4);
}

// GPI's fits beside an exhaustive search that shares nothing with them but the data
// (tests/analysis/support/gpi_reference.h): 20 taxels of each of three simulated sensors. Constants of the search were
// chosen on sensor seeds 1 to 3 and 11 to 13; never on these.

TEST_CASE("GPI: no fit of 20 taxels per seed has a larger J than 200 starts of an independent search") {
  constexpr std::size_t kTaxels = 20;
  for (const unsigned seed : {7101U, 7102U, 7103U}) {
    const std::vector<FitData> taxels = specimen_taxels(seed, kTaxels, 0.0005);
    const auto prepared = prepare("gpi", taxels.front());
    for (std::size_t i = 0; i < kTaxels; ++i) {
      const double own = prepared->fit(taxels[i]).j;
      const double reference = GpiReference(taxels[i]).least(200, 1000 * seed + static_cast<unsigned>(i));
      INFO("sensor " << seed << ", taxel " << i << ": J " << own << ", reference " << reference);
      CHECK(own <= reference * (1.0 + 1e-6));
    }
  }
}
