// On the kinds of arrays that the search was made on; identify_long.cpp has others.
#include "tests/analysis/identify/elam/exhaustive_comparison.h"

using namespace exhaustive_comparison;

TEST_CASE("identification finds the best of an exhaustive search of the whole box, clipped taxels included") {
  Tally tally;
  for (const Kind& kind :
       {Kind{"quiet", 77, 0.0015, 0.015, 1, 0, 2, 5}, Kind{"12 mV", 177, 0.012, 0.015, 1, 0, 2, 5},
        Kind{"30 mV, one repeat", 7, 0.030, 0.02, 1, 0, 1, 1}, Kind{"spread splits", 8, 0.004, 0.03, 3, 0, 2, 5},
        Kind{"clipped", 10, 0.0015, 0.015, 1, 0.9, 2, 5}, Kind{"clipped, 12 mV", 11, 0.012, 0.015, 2, 0.85, 2, 2},
        Kind{"clipped, spread", 112, 0.004, 0.03, 2, 0.7, 2, 5}})
    compare(kind, 4, tally);
  WARN(tally.fits << " fits, the worst above the exhaustive search by " << tally.worst << " of J");
}
