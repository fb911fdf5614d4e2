// A turn, or a begin, within a hundredth of the range from its end counts as the end itself: at exactly a hundredth,
// and at the next number beyond it. Ranges are 64 long and begin or end at 0, so that a hundredth is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/identify/congruency.h"
#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/folds.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/preisach.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/bits.h"

using namespace tactbench::analysis;
using to_the_bit::just_above;
using to_the_bit::just_below;

namespace {

constexpr double kHundredth = 0.01 * 64.0;

History way_of(const std::string& name, const std::vector<double>& x, double low) {
  History way{name, x, {}, branches_along(x), {}, {}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double share = (x[i] - low) / 64.0;
    const bool falls = i > 0 && x[i] < x[i - 1];
    way.y.push_back(64.0 * (falls ? share * (1.5 - 0.5 * share) : share * (0.5 + 0.5 * share)));
  }
  return way;
}

// Patterns bent as the ways are, from `low` on.
FitData over_64(double low, const std::vector<std::vector<double>>& ways) {
  std::vector<double> x, up, down;
  for (int i = 0; i <= 8; ++i) {
    const double share = i / 8.0;
    x.push_back(low + 8.0 * i);
    up.push_back(64.0 * share * (0.5 + 0.5 * share));
    down.push_back(64.0 * share * (1.5 - 0.5 * share));
  }
  FitData data{{}, PatternCurve(x, up, 0.0, 64.0), PatternCurve(x, down, 0.0, 64.0)};
  for (const std::vector<double>& way : ways) data.histories.push_back(way_of("way", way, low));
  return data;
}

int pairs_of(double low, const std::vector<std::vector<double>>& ways) {
  return find_divider(over_64(low, ways)).pairs;
}

}  // namespace

TEST_CASE("exact hundredths: branches of the congruency test come from an end, and turn inside") {
  // Rises from the top by way of three turns, falls from 40 that come from the bottom.
  const auto rises = [](double turn, double fall_from) {
    return pairs_of(0.0, {{fall_from, 40, 0}, {64, turn, 64}, {64, 20, 64}, {64, 30, 64}});
  };
  CHECK(rises(10.0, 0.0) == 3);
  CHECK(rises(kHundredth, 0.0) == 2);
  CHECK(rises(just_above(kHundredth), 0.0) == 3);
  CHECK(rises(10.0, kHundredth) == 3);
  CHECK(rises(10.0, just_above(kHundredth)) == 0);
  const auto falls = [](double turn, double rise_from) {
    return pairs_of(-64.0, {{rise_from, -50, rise_from}, {-64, turn, -64}, {-64, -20, -64}, {-64, -30, -64}});
  };
  CHECK(falls(-10.0, 0.0) == 3);
  CHECK(falls(-kHundredth, 0.0) == 2);
  CHECK(falls(just_below(-kHundredth), 0.0) == 3);
  CHECK(falls(-10.0, -kHundredth) == 3);
  CHECK(falls(-10.0, just_below(-kHundredth)) == 0);
}

TEST_CASE("exact hundredths: branches that begin there are never held out") {
  const auto rises = [](double turn) { return folds_of(over_64(0.0, {{0, 64, turn, 64, 30, 64, 20, 64, 0}})).size(); };
  CHECK(rises(kHundredth) == 2);
  CHECK(rises(just_above(kHundredth)) == 3);
  const auto falls = [](double turn) {
    return folds_of(over_64(-64.0, {{-64, 0, -64, turn, -64, -30, -64, -20, -64}})).size();
  };
  CHECK(falls(-kHundredth) == 2);
  CHECK(falls(just_below(-kHundredth)) == 3);
}

TEST_CASE("exact hundredths: ELAM's branches from there begin at the pattern's end") {
  const FitData low = over_64(0.0, {}), high = over_64(-64.0, {});
  const ElamModel rising{low.ascending, low.descending, {}, {}}, falling{high.ascending, high.descending, {}, {}};
  const auto up_from = [&](double x) { return turning_point(rising, {true, {x, 10}, {3, 4}}); };
  const auto down_from = [&](double x) { return turning_point(falling, {false, {x, -60}, {50, 4}}); };
  CHECK((up_from(kHundredth).x == 0.0 && up_from(kHundredth).y == 0.0));
  CHECK((up_from(just_above(kHundredth)).x == just_above(kHundredth) && up_from(just_above(kHundredth)).y == 3.0));
  CHECK((down_from(-kHundredth).x == 0.0 && down_from(-kHundredth).y == 64.0));
  CHECK((down_from(just_below(-kHundredth)).x == just_below(-kHundredth)));
  CHECK(down_from(just_below(-kHundredth)).y == 50.0);
  // A recording that begins there has measured its first turn; one that begins further inside has not, and the samples
  // of its first branch are left out.
  const auto samples = [](double begin) {
    return identify("elam", over_64(0.0, {{begin, 32, 64, 32, 0, 32, 64, 32, 0}})).samples;
  };
  CHECK(samples(kHundredth) == 8);
  CHECK(samples(just_above(kHundredth)) == 6);
}

TEST_CASE("exact hundredths: samples of external branches determine nothing of a film") {
  const auto open = [](double low, const std::vector<double>& way) {
    IdentifyOptions options;
    options.cells = 3;
    return identify("preisach", over_64(low, {way}), options).undetermined.size();
  };
  CHECK(open(0.0, {0, 30, 64, 30, kHundredth, 30, 64, 30, 0}) == 1);
  CHECK(open(0.0, {0, 30, 64, 30, just_above(kHundredth), 30, 64, 30, 0}) == 0);
  CHECK(open(-64.0, {-64, -30, -kHundredth, -30, -64, -30, 0, -30, -64}) == 1);
  CHECK(open(-64.0, {-64, -30, just_below(-kHundredth), -30, -64, -30, 0, -30, -64}) == 0);
}

TEST_CASE("exact hundredths: a scored recording that begins there begins at rest") {
  const PreisachModel model(0.0, 64.0, 0.0, {1, 1, 1});
  ScoreOptions options;
  options.x_high = 64.0;
  options.y_high = 3.0;
  const auto worst = [&](double begin) {
    const std::vector<double> x{begin, 10, 20};
    const History history{"h", x, {1.5, 2.0, 2.5}, branches_along(x), {}, {}};
    return score(model, std::vector<History>{history}, options).compensated.max;
  };
  CHECK(worst(kHundredth) == worst(0.0));
  CHECK(std::abs(worst(just_above(kHundredth)) - worst(0.0)) > 1.0);
}
