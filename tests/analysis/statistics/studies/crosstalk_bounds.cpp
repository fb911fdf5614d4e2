// Crosstalk to each of its bounds, on prints of one taxel, or two, whose shares are given by zone.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "analysis/statistics/studies/studies.h"

using namespace tactbench::analysis;

namespace {

constexpr int kMap = 17;

struct PrintShares {
  double row = 0.0, column = 0.0, elsewhere = 0.0;  // beyond two pitches along rows and columns
  double peak_v = 1.0;
  double right = 0.0, corner = 0.0;  // of the next taxel along the row, and of the one next to both
};

// One taxel at (row, column) of an array, 1 V over a zero of 0.125 V; nothing else within two pitches but what is
// asked.
PointFrame small_print(int position, int at_row, int at_column, const PrintShares& shares, int rows = kMap,
                       int columns = kMap) {
  PointFrame frame{position, true, 5.0, {}};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int down = std::abs(row - at_row), along = std::abs(column - at_column);
      double share = shares.elsewhere;
      if (down == 0 && along == 0)
        share = 1.0;
      else if (row == at_row && column == at_column + 1)
        share = shares.right;
      else if (row == at_row + 1 && column == at_column + 1)
        share = shares.corner;
      else if (down <= 2 && along <= 2)
        share = 0.0;
      else if (down <= 1)
        share = shares.row;
      else if (along <= 1)
        share = shares.column;
      frame.volts.push_back(0.125 + shares.peak_v * share);
    }
  }
  return frame;
}

// On the diagonal, so that no two share a row or a column and each taxel is at rest under two of the four.
std::vector<PointFrame> on_the_diagonal(const std::vector<PrintShares>& shares) {
  std::vector<PointFrame> frames;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const int at = 2 + 4 * static_cast<int>(i);
    frames.push_back(small_print(static_cast<int>(i), at, at, shares[i]));
  }
  return frames;
}

Crosstalk crosstalk_on(const std::vector<PrintShares>& shares) {
  return crosstalk_of(7, on_the_diagonal(shares), kMap, kMap);
}

}  // namespace

TEST_CASE("crosstalk bounds: a taxel makes the print's centre from a tenth of the peak on") {
  // A neighbour of 3/32 counts for nothing; one of 1/8 pulls the centre by 1/9 of a pitch: the column two to the left
  // is then beyond the reach, and the one to the left no loaded one any more.
  PrintShares below, above;
  below.right = 0.09375;
  above.right = 0.125;
  const Crosstalk still = crosstalk_on({below, below, below, below}),
                  pulled = crosstalk_on({above, above, above, above});
  CHECK(still.row.samples == 4 * 3 * (17 - 5));
  CHECK(still.column.samples == 4 * 3 * (17 - 5));
  CHECK(pulled.row.samples == 4 * 3 * (17 - 4));
  CHECK(pulled.column.samples == 4 * 2 * (17 - 5));
  CHECK(pulled.elsewhere.samples == 4 * (17 * 17 - 5 * 4 - 3 * 13 - 2 * 12));
}

TEST_CASE("crosstalk bounds: the print's centre is weighted by the shares along both directions") {
  // 1 and 0.5 at one pitch down and to the right: the centre is a third of a pitch off. Rows and columns at -1/3 and
  // +2/3 are loaded; -4/3 to +5/3 are within reach.
  PrintShares two;
  two.corner = 0.5;
  const Crosstalk c = crosstalk_on({two, two, two, two});
  CHECK(c.row.samples == 4 * 2 * (17 - 4));
  CHECK(c.column.samples == 4 * 2 * (17 - 4));
  CHECK(c.elsewhere.samples == 4 * (17 * 17 - 4 * 4 - 2 * 2 * 13));
  // Distances to the nearest whole pitch: of the two loaded rows at none 1 and 0, at one 0 0 (-4/3) and 0 0.5 (+2/3).
  CHECK(c.along_row_share[0] == Approx(0.5));
  CHECK(c.along_row_share[1] == Approx(0.125));
  CHECK(c.along_column_share[0] == Approx(0.5));
  CHECK(c.along_column_share[1] == Approx(0.125));
}

TEST_CASE("crosstalk bounds: a frame whose peak is below 50 mV shows no print, and four positions are needed") {
  PrintShares full, weak, enough;
  weak.peak_v = 0.049;
  enough.peak_v = 0.051;
  CHECK_FALSE(crosstalk_on({full, full, full, weak}).assessed());
  CHECK_FALSE(crosstalk_on({full, full, full, weak}).not_assessed.empty());
  CHECK(crosstalk_on({full, full, full, enough}).positions == 4);
  CHECK_FALSE(crosstalk_on({full, full, full}).assessed());
  const Crosstalk none = crosstalk_of(7, {}, kMap, kMap);
  CHECK_FALSE(none.not_assessed.empty());
  CHECK(none.run == 7);
}

TEST_CASE("crosstalk by hand: the uncertainty of a zone's share is that of the mean over the positions") {
  std::vector<PrintShares> shares(4);
  for (std::size_t i = 0; i < 4; ++i) shares[i].row = 0.002 * static_cast<double>(i + 1);
  const Crosstalk c = crosstalk_on(shares);
  // 2, 4, 6, 8 thousandths: mean 5, variance 20 / 3, over four.
  CHECK(c.row.mean_share == Approx(0.005));
  CHECK(c.row.u_share == Approx(0.001 * std::sqrt(20.0 / 3.0 / 4.0)));
  CHECK(c.row.max_share == Approx(0.008));
  CHECK(c.column.u_share == Approx(0.0).margin(1e-12));
  CHECK(c.force_n == Approx(5.0));
}

TEST_CASE("crosstalk bounds: a ghost line shows half a percent more than elsewhere") {
  PrintShares below, above;
  below.row = below.column = 0.0049;
  above.row = above.column = 0.0051;
  const Crosstalk none = crosstalk_on({below, below, below, below});
  CHECK(none.ghost_rows.empty());
  CHECK(none.ghost_columns.empty());
  const Crosstalk all = crosstalk_on({below, above, below, below});
  REQUIRE(all.ghost_rows.size() == 3);
  REQUIRE(all.ghost_columns.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(all.ghost_rows[i].line == 5 + static_cast<int>(i));
    CHECK(all.ghost_rows[i].mean_share == Approx(0.0051));
    CHECK(all.ghost_columns[i].line == 5 + static_cast<int>(i));
  }
}

TEST_CASE("crosstalk bounds: a ghost line stands out of elsewhere by three standard deviations of it") {
  // Elsewhere shows 8 thousandths at one of four positions: 2 in the mean, u = 4 / sqrt(4) = 2 (variance 16).
  const auto ghosts = [](double row) {
    std::vector<PrintShares> shares(4);
    shares[0].elsewhere = 0.008;
    shares[1].row = row;
    return crosstalk_on(shares);
  };
  CHECK(ghosts(0.0).elsewhere.mean_share == Approx(0.002).epsilon(0.02));
  CHECK(ghosts(0.0).elsewhere.u_share == Approx(0.002).epsilon(0.02));
  CHECK(ghosts(0.0076).ghost_rows.empty());  // 5.6 beyond, of the 6 that are needed
  CHECK(ghosts(0.0085).ghost_rows.size() == 3);
}

TEST_CASE("crosstalk bounds: a ghost line's own scatter over its positions counts") {
  // Row 2 lies under two prints, 12 thousandths in the mean; +-6 leave u = 6, +-2 leave u = 2.
  const auto ghosts = [](double half) {
    std::vector<PointFrame> frames;
    for (int i = 0; i < 4; ++i) {
      PrintShares own;
      if (i < 2) own.row = i == 0 ? 0.012 - half : 0.012 + half;
      frames.push_back(small_print(i, i < 2 ? 2 : 8 + 3 * (i - 2), 2 + 4 * i, own));
    }
    return crosstalk_of(7, frames, kMap, kMap).ghost_rows;
  };
  CHECK(ghosts(0.006).empty());
  REQUIRE(ghosts(0.002).size() == 3);
  CHECK(ghosts(0.002)[0].line == 1);
  CHECK(ghosts(0.002)[1].mean_share == Approx(0.012));
}

TEST_CASE("crosstalk: a zone that no taxel lies in tells nothing, and its lines are no ghosts") {
  // Five columns: all of a print's rows lie within its reach along them.
  std::vector<PointFrame> frames;
  for (int i = 0; i < 4; ++i) {
    PrintShares own;
    own.column = 0.004;
    frames.push_back(small_print(i, 2 + 4 * i, 2, own, kMap, 5));
  }
  // Each taxel of the middle columns is at rest under none of the prints but its own rows': the quartile is the second.
  const Crosstalk c = crosstalk_of(7, frames, kMap, 5);
  REQUIRE(c.assessed());
  CHECK(c.row.samples == 0);
  CHECK((std::isnan(c.row.mean_share) && std::isnan(c.row.u_share) && std::isnan(c.row.max_share)));
  CHECK(c.ghost_rows.empty());
  CHECK(c.column.samples == 4 * 3 * (17 - 5));
  CHECK(c.elsewhere.samples == 4 * 2 * (17 - 5));
}

TEST_CASE("crosstalk of an array that is longer than high: distances as far as its longer side, none where none is") {
  std::vector<PointFrame> frames;
  for (int i = 0; i < 4; ++i) {
    PrintShares own;
    own.row = 0.004;
    own.column = 0.002;
    frames.push_back(small_print(i, i % 2 == 0 ? 2 : 6, 2 + 4 * i, own, 9, kMap));
  }
  const Crosstalk c = crosstalk_of(7, frames, 9, kMap);
  REQUIRE(c.assessed());
  REQUIRE(c.distance_pitches.size() == 15);  // from column 2 to the last of 17
  CHECK(c.distance_pitches.back() == 14.0);
  CHECK(c.along_row_share[14] == Approx(0.004));
  CHECK(c.along_column_share[6] == Approx(0.002));  // from row 2 to the last of 9
  CHECK(std::isnan(c.along_column_share[7]));
  CHECK(std::isnan(c.along_column_share[14]));
  // Two prints lie in each row, so the line's samples are those of both.
  CHECK(c.row.samples == 4 * 3 * (17 - 5));
  CHECK(c.column.samples == 4 * 3 * (9 - 5));
}

TEST_CASE("crosstalk: only rising frames of the highest force count, within a tenth of it") {
  std::vector<PointFrame> frames = on_the_diagonal(std::vector<PrintShares>(4));
  struct More {
    int position;
    double force_n;
    bool rising;
  };
  // The second is just a tenth less, the third a lower level, the last on its way down.
  for (const More& more : {More{0, 4.6, true}, More{3, 4.5, true}, More{1, 4.4, true}, More{2, 5.0, false}}) {
    PointFrame frame = frames[static_cast<std::size_t>(more.position)];
    frame.force_n = more.force_n;
    frame.rising = more.rising;
    frames.push_back(frame);
  }
  const Crosstalk c = crosstalk_of(7, frames, kMap, kMap);
  REQUIRE(c.assessed());
  CHECK(c.positions == 4);
  CHECK(c.reach_pitches == 2.0);
  CHECK(c.force_n == Approx((4 * 5.0 + 4.6 + 4.5) / 6));
  CHECK(c.row.samples == 6 * 3 * 12);
  CHECK(c.elsewhere.samples == 6 * (17 * 17 - 5 * 5 - 2 * 3 * 12));
}
