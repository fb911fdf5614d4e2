// By command: larger arrays than identify_slow.cpp has, and arrays that nothing was chosen on.
#include "tests/analysis/identify/elam/exhaustive_comparison.h"

using namespace exhaustive_comparison;

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
