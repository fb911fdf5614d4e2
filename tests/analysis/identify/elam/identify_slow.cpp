// On the kinds of arrays that the search was made on; identify_long.cpp has more of each, and others.
#include "tests/analysis/identify/elam/exhaustive_comparison.h"

using namespace exhaustive_comparison;

TEST_CASE("identification finds the best of an exhaustive search of the whole box, clipped taxels included") {
  for (const Kind& kind : kKinds) compare(kind, 2);
}
