// Figures of further runs and of raw behaviour against answers worked out on paper.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

// Rising from 0 to 40 psi in the given time; `mean_v` of the two live taxels at each step.
Repeat paced(double seconds, const std::vector<double>& mean_v) {
  Repeat repeat;
  for (std::size_t i = 0; i < mean_v.size(); ++i) {
    repeat.steps.push_back({20.0 * static_cast<double>(i), 20.0 * static_cast<double>(i),
                            seconds * static_cast<double>(i) / 2.0, i == 1 ? 3.0 : 0.0});
    repeat.volts.insert(repeat.volts.end(), {mean_v[i] - 0.25, mean_v[i] + 0.25, 9.0});
  }
  return repeat;
}

}  // namespace

TEST_CASE("rate study: each faster repeat is compared with the slowest") {
  // Full scale 4.5 V. The fast repeat is off by 0, 0.09 and 0.27 V; one of 52 s is no other pace than one of 60 s.
  const Dataset data = dataset_of({{"rate", {paced(30, {1, 2.09, 2.73}), paced(60, {1, 2, 3}), paced(52, {1, 4, 4})}}});
  const std::vector<RateHoldRun> runs = rate_hold_of(data, straight_fit());
  REQUIRE(runs.size() == 1);
  CHECK(runs[0].output_max_share == Approx(0.06));
  CHECK(runs[0].output_mean_share == Approx((0.0 + 0.02 + 0.06) / 3));
  // Alike in pace: nothing is told.
  const Dataset alike = dataset_of({{"rate", {paced(60, {1, 2, 3}), paced(52, {1, 4, 4})}}});
  CHECK(rate_hold_of(alike, straight_fit())[0].output_max_share == 0.0);
}

TEST_CASE("rate study: compensation errors by rate and by hold match hand-computed values") {
  // Slow: 20 psi in 30 s, held 3 s at the middle level. The first taxel reads 0.75, 1.75, 2.75 V as 15, 35, 55 psi at
  // 0, 20 and 40 psi, the second 1.25, 2.25, 3.25 V as 12.5, 22.5, 32.5 psi: off by 15, 15, 15 and 12.5, 2.5, 7.5.
  const RateHoldRun run = rate_hold_of(dataset_of({{"rate", {paced(60, {1, 2, 3})}}}), straight_fit()).front();
  CHECK(run.error.samples == 6);
  CHECK(run.error.sum == Approx(67.5));
  CHECK(run.error.mean() == Approx(11.25));
  CHECK(run.error.max == Approx(15.0));
  REQUIRE(run.by_rate.size() == 1);  // 0.67 psi/s
  CHECK((run.by_rate[0].low == Approx(0.5) && run.by_rate[0].high == Approx(1.0)));
  CHECK(run.by_rate[0].error.samples == 4);
  CHECK(run.by_rate[0].error.mean() == Approx((15.0 + 15.0 + 2.5 + 7.5) / 4));
  REQUIRE(run.by_hold.size() == 1);  // 3 s
  CHECK((run.by_hold[0].low == Approx(2.0) && run.by_hold[0].high == Approx(5.0)));
  CHECK(run.by_hold[0].error.mean() == Approx((15.0 + 2.5) / 2));
}

TEST_CASE("zero return: mean of the repeats, largest one and worst taxel match hand-computed values") {
  // The live taxels end +3 and +1, -4 and -6, +1 and +1 mV off their start: +2, -5 and +1 mV in the mean.
  const std::vector<Sample> steps{{0, 0}, {20, 20}, {0, 0}};
  SequenceData sequence{"loop", {}};
  for (const auto& [first, second] : {std::pair{3.0, 1.0}, std::pair{-4.0, -6.0}, std::pair{1.0, 1.0}}) {
    Repeat repeat{steps, {0.1, 0.2, 9, 1, 2, 9, 0.1, 0.2, 5}};
    repeat.volts[6] += 1e-3 * first;
    repeat.volts[7] += 1e-3 * second;
    sequence.repeats.push_back(repeat);
  }
  const Behaviour b = behaviour_of(dataset_of({sequence}), {0, 1});
  REQUIRE(b.zero_returns.size() == 1);
  CHECK(b.zero_returns[0].mean_v == Approx(-0.002 / 3));
  CHECK(b.zero_returns[0].largest_v == Approx(-0.005));
  CHECK(b.zero_returns[0].worst_taxel == 1);
  CHECK(b.zero_returns[0].worst_taxel_v == Approx(-0.004 / 3));
}

TEST_CASE("zero return: is from the first to the last time at the lowest pressure, wherever the sequence begins") {
  // Both taxels' outputs are 1 V and 2 V at the lowest pressure; each time there has its own excess in mV.
  struct Way {
    const char* what;
    std::vector<double> setpoints, first_mv, second_mv;
    double mean_mv;  // nothing: not a number
    int worst;
    double worst_mv;
  };
  const std::vector<Way> ways = {
      {"begins above it", {30, 0, 30, 60, 30, 0}, {50, 1, 50, 50, 50, 4}, {70, 2, 70, 70, 70, 1}, 1.0, 0, 3.0},
      {"ends above it", {0, 60, 0, 40}, {1, 50, 3, 50}, {1, 70, 7, 70}, 4.0, 1, 6.0},
      {"three times", {20, 0, 60, 0, 60, 0, 20}, {9, 1, 9, 50, 9, 2, 9}, {9, 1, 9, 70, 9, -4, 9}, -2.0, 1, -5.0},
      {"rests there first", {0, 0, 60, 0}, {1, 50, 9, 2}, {1, 70, 9, 2}, 1.0, 0, 1.0},
      {"the lowest is not 0", {40, 20, 60, 20}, {9, 5, 9, 2}, {9, 5, 9, 1}, -3.5, 1, -4.0},
      {"never goes away", {0, 0, 0}, {1, 2, 3}, {1, 2, 3}, std::nan(""), 0, 0},
      {"does not come back", {40, 0, 0, 40}, {1, 2, 3, 4}, {1, 2, 3, 4}, std::nan(""), 0, 0},
      {"is there once", {40, 0, 40}, {1, 2, 3}, {1, 2, 3}, std::nan(""), 0, 0}};
  for (const Way& way : ways) {
    INFO(way.what);
    Repeat repeat;
    for (std::size_t i = 0; i < way.setpoints.size(); ++i) {
      repeat.steps.push_back({way.setpoints[i], way.setpoints[i]});
      repeat.volts.insert(repeat.volts.end(), {1 + 1e-3 * way.first_mv[i], 2 + 1e-3 * way.second_mv[i], 9.0});
    }
    const Behaviour b = behaviour_of(dataset_of({{"way", {repeat}}}), {0, 1});
    REQUIRE(b.zero_returns.size() == (std::isnan(way.mean_mv) ? 0 : 1));
    if (b.zero_returns.empty()) continue;
    CHECK(b.zero_returns[0].sequence == "way");
    CHECK(b.zero_returns[0].repeats == 1);
    CHECK(b.zero_returns[0].mean_v == Approx(1e-3 * way.mean_mv));
    CHECK(b.zero_returns[0].largest_v == Approx(1e-3 * way.mean_mv));
    CHECK(b.zero_returns[0].worst_taxel == way.worst);
    CHECK(b.zero_returns[0].worst_taxel_v == Approx(1e-3 * way.worst_mv));
  }
}
