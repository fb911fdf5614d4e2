// What the report's pages are made of beside the evaluation, against answers worked out on paper: judgements of levels,
// deviations and spreads.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/report/parts.h"

using namespace tactbench::analysis;

namespace {

const double kNotKnown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("a level is worse by what compensation widened: the distance, the spread going up, the spread going down") {
  LevelFigures level;
  level.raw_std_up = level.raw_std_down = 0.1;
  level.comp_std_up = level.comp_std_down = 0.1;  // alike is not worse
  CHECK_FALSE(judge_level(level).any());
  level.comp_std_up = 0.11;
  CHECK((judge_level(level).std_up && !judge_level(level).std_down && !judge_level(level).distance));
  level.comp_std_up = 0.09;
  level.comp_std_down = 0.11;
  CHECK((!judge_level(level).std_up && judge_level(level).std_down && judge_level(level).any()));
  level.comp_std_down = 0.09;
  level.made_worse = true;
  CHECK((judge_level(level).distance && judge_level(level).any()));
}

TEST_CASE("deviations and spreads by hand leave out what is not finite") {
  const Deviation off = deviation(std::vector{1.0, 2.0, kNotKnown, 5.0}, std::vector{1.5, 0.5, 3.0, 5.0});
  CHECK(off.mean == Approx((0.5 + 1.5 + 0.0) / 3));
  CHECK(off.maximum == Approx(1.5));
  CHECK(std::isnan(deviation(std::vector{kNotKnown}, std::vector{1.0}).mean));
  const Spread even = spread_of({4.0, 1.0, kNotKnown, 3.0, 10.0});
  CHECK((even.low == 1.0 && even.median == 3.5 && even.high == 10.0 && even.count == 4));
  CHECK(spread_of({4.0, 1.0, 3.0}).median == 3.0);
  CHECK(std::isnan(spread_of({kNotKnown}).high));
}
