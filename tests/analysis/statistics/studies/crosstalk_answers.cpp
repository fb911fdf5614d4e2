// Crosstalk of prints whose shares are known taxel by taxel: who counts for which zone, to the very edge of the reach.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "analysis/statistics/studies/studies.h"

using namespace tactbench::analysis;

namespace {

constexpr int kWidePattern = 17;

// One taxel of 1 V over a zero of 0.1 V. Those within two pitches along rows and columns show 5 % of it (too little to
// move the print's centre); further away its rows show 0.4 % and its columns 0.3 %, one pitch to either side included.
PointFrame print(int position, int at, double force_n, bool rising = true) {
  PointFrame frame{position, rising, force_n, {}};
  for (int row = 0; row < kWidePattern; ++row) {
    for (int column = 0; column < kWidePattern; ++column) {
      const int down = std::abs(row - at), along = std::abs(column - at);
      double share = 0.0;
      if (down == 0 && along == 0)
        share = 1.0;
      else if (down <= 2 && along <= 2)
        share = 0.05;
      else if (down <= 1)
        share = 0.004;
      else if (along <= 1)
        share = 0.003;
      frame.volts.push_back(0.1 + share);
    }
  }
  return frame;
}

// No two positions share a row or a column, so that each taxel is at rest under two prints of four at least.
std::vector<PointFrame> four_prints(double force_n = 5.0) {
  std::vector<PointFrame> frames;
  for (int position = 0; position < 4; ++position) frames.push_back(print(position, 2 + 4 * position, force_n));
  return frames;
}

}  // namespace

TEST_CASE("taxels at exactly the reach do not count, the next ones do") {
  const Crosstalk c = crosstalk_of(7, four_prints(), kWidePattern, kWidePattern);
  REQUIRE(c.assessed());
  CHECK(c.run == 7);
  CHECK(c.positions == 4);
  CHECK(c.reach_pitches == 2.0);
  // Three rows of 17 columns less the five within reach.
  CHECK(c.row.samples == 4 * 3 * 12);
  CHECK(c.row.mean_share == Approx(0.004));
  CHECK(c.row.max_share == Approx(0.004));
  CHECK(c.row.u_share == Approx(0.0).margin(1e-12));
  CHECK(c.column.samples == 4 * 3 * 12);
  CHECK(c.column.mean_share == Approx(0.003));
  CHECK(c.elsewhere.samples == 4 * (17 * 17 - 5 * 5 - 2 * 3 * 12));
  CHECK(c.elsewhere.mean_share == Approx(0.0).margin(1e-12));
  CHECK(c.ghost_rows.empty());  // 0.4 % is below the share that is worth a name
}

TEST_CASE("shares over distance by hand, the print itself included") {
  const Crosstalk c = crosstalk_of(7, four_prints(), kWidePattern, kWidePattern);
  REQUIRE(c.distance_pitches.size() == 15);  // the corner prints see 14 pitches
  CHECK(c.distance_pitches[3] == 3.0);
  // Over the three rows next to the centre: 1, 0.05, 0.05 at no distance.
  CHECK(c.along_row_share[0] == Approx(1.1 / 3));
  CHECK(c.along_row_share[2] == Approx(0.05));
  CHECK(c.along_row_share[3] == Approx(0.004));
  CHECK(c.along_row_share[14] == Approx(0.004));
  CHECK(c.along_column_share[0] == Approx(1.1 / 3));
  CHECK(c.along_column_share[3] == Approx(0.003));
}

TEST_CASE("only rising frames of the highest force count, within a tenth of it") {
  std::vector<PointFrame> frames = four_prints(5.0);
  frames.push_back(print(0, 2, 4.6));
  frames.push_back(print(3, 14, 4.5));         // just a tenth less
  frames.push_back(print(1, 6, 4.4));          // a lower level
  frames.push_back(print(2, 10, 5.0, false));  // on its way down
  const Crosstalk c = crosstalk_of(7, frames, kWidePattern, kWidePattern);
  REQUIRE(c.assessed());
  CHECK(c.force_n == Approx((4 * 5.0 + 4.6 + 4.5) / 6));
  CHECK(c.row.samples == 6 * 3 * 12);
}
