// The lag of an array from repeats at two rates, on films that are straight lines: its time and the taxels' shares come
// out as they were put in, and doubt draws a taxel toward the array by what it is worth.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/dynamic/dynamics_search.h"
#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

// 0, 10, 20, 30, 20, 10, 0: a slope at the second, third, fifth and sixth.
const std::vector<double> kUpAndDown{0, 10, 20, 30, 20, 10, 0};

// One of the times that are tried, from 0.1 s on by tenths more.
double lag_time(int k) {
  double lag_s = 0.1;
  for (int i = 0; i < k; ++i) lag_s *= 1.1;
  return lag_s;
}

std::vector<double> zeros_of_taxels(const std::vector<WalkedTaxel>& taxels) {
  std::vector<double> zeros;
  for (const WalkedTaxel& taxel : taxels) zeros.push_back(taxel.zero);
  return zeros;
}

ArrayDynamics lag_of(const Dynamics& d, const std::vector<WalkedTaxel>& taxels,
                     const std::vector<WalkedSequence>& sequences) {
  ArrayDynamics found = nothing_known(taxels.size());
  find_lag(walked_run(d, taxels, sequences, 30.0), zeros_of_taxels(taxels), std::vector<bool>(taxels.size(), true),
           found);
  return found;
}

}  // namespace

TEST_CASE("lag search: recovers the time constant and each taxel's share, for any slopes and zeros", "[dynamic]") {
  for (const int k : {0, 12, 24, 45}) {
    Dynamics d;
    d.lag_s = lag_time(k);
    const double fast = d.lag_s, slow = 40.0 * d.lag_s;
    const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.04}, {0.2, 0.1, 1.0, 0.08}};
    const ArrayDynamics found = lag_of(d, taxels, {{"rate", {{kUpAndDown, fast}, {kUpAndDown, slow}}}});
    CAPTURE(k);
    CHECK(found.rate_samples == 4);
    CHECK(found.shared.lag_s == d.lag_s);
    CHECK(found.shared.lag_share == Approx(0.06).epsilon(1e-6));
    CHECK(found.lag_share[0] == Approx(0.04).epsilon(1e-6));
    CHECK(found.lag_share[1] == Approx(0.08).epsilon(1e-6));
  }
}

TEST_CASE("lag search: accounts for unequal pressures at the two rates, conditioning and creep", "[dynamic]") {
  Dynamics d;
  d.creep_share = {0.05, 0.03, 0.02};
  d.creep_half = 6.0;
  d.lag_s = lag_time(24);
  // Twice the creep of the array, and half of it. A sequence without a second rate comes before.
  const std::vector<WalkedTaxel> taxels = {{0.1, 0.05, 2.0, 0.05}, {0.3, 0.05, 0.5, 0.09}};
  const Dataset data = walked_run(d, taxels,
                                  {{"other", {{{0, 15, 30, 15, 0}, 2.0, 0.0, 0.0}}},
                                   {"rate", {{kUpAndDown, 0.8, 50.0, 0.4}, {kUpAndDown, 60.0, 70.0, 0.0}}}},
                                  30.0);
  ArrayDynamics found = nothing_known(2);
  found.shared.creep_share = d.creep_share;
  found.shared.creep_half = d.creep_half;
  found.creep_scale = {2.0, 0.5};
  find_lag(data, {0.1, 0.3}, {true, true}, found);
  CHECK(found.rate_samples == 4);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.shared.lag_share == Approx(0.07).epsilon(1e-6));
  CHECK(found.lag_share[0] == Approx(0.05).epsilon(1e-6));
  CHECK(found.lag_share[1] == Approx(0.09).epsilon(1e-6));
}

TEST_CASE("lag search: compares the fastest with the slowest repeat, the first of equal ones", "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  Dataset data = walked_run(d, taxels,
                            {{"rate",
                              {{kUpAndDown, 2.0},
                               {kUpAndDown, 0.75},
                               {kUpAndDown, 0.75},
                               {kUpAndDown, 40.0},
                               {kUpAndDown, 40.0},
                               {kUpAndDown, 3.0}}}},
                            30.0);
  for (const std::size_t other : {0U, 2U, 4U, 5U})
    for (std::size_t i = 0; i < kUpAndDown.size(); ++i)
      data.sequences[0].repeats[other].volts[i] += 0.1 * static_cast<double>(i % 2);
  ArrayDynamics found = nothing_known(1);
  find_lag(data, {0.0}, {true}, found);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.lag_share[0] == Approx(0.06).epsilon(1e-6));
}

TEST_CASE("lag search: two rates must differ by more than a factor of two", "[dynamic]") {
  Dynamics d;
  d.lag_s = 0.5;
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  const auto samples = [&](double slow) {
    return lag_of(d, taxels, {{"rate", {{kUpAndDown, 1.0}, {kUpAndDown, slow}}}}).rate_samples;
  };
  CHECK(samples(2.0) == 0);
  CHECK(samples(2.0625) == 4);
  CHECK(samples(0.5) == 0);
  CHECK(samples(0.4375) == 4);
  CHECK(lag_of(d, taxels, {{"rate", {{{0, 10}, 1.0}, {{0, 10}, 4.0}}}}).rate_samples == 0);
  CHECK(lag_of(d, taxels, {{"rate", {{{0, 10, 20}, 1.0}, {{0, 10, 20}, 4.0}}}}).rate_samples == 1);
  CHECK(lag_of(d, taxels, {{"rate", {}}}).rate_samples == 0);
  // Of the two sequences one has two rates; its rows are its own.
  CHECK(lag_of(d, taxels, {{"one", {{kUpAndDown, 1.0}}}, {"rate", {{{0, 10, 20}, 1.0}, {{0, 10, 20}, 4.0}}}})
            .rate_samples == 1);
}

TEST_CASE("lag search: samples at a turning point or on a held level are not used", "[dynamic]") {
  Dynamics d;
  d.lag_s = 0.5;
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  const std::vector<double> held{0, 10, 10, 20, 30, 20, 30};
  CHECK(lag_of(d, taxels, {{"rate", {{held, 1.0}, {held, 4.0}}}}).rate_samples == 1);  // that at 20 on the way up
}

TEST_CASE("lag search: shares are limited to 0.5, and the time constant to between 0.1 and 12 s", "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const auto found_of = [&](double one, double other, double fast, double slow) {
    return lag_of(d, {{0.0, 0.1, 1.0, one}, {0.0, 0.1, 1.0, other}},
                  {{"rate", {{kUpAndDown, fast}, {kUpAndDown, slow}}}});
  };
  const ArrayDynamics most = found_of(0.7, 0.8, 0.8, 40.0);
  CHECK(most.shared.lag_share == 0.5);
  CHECK(most.lag_share == std::vector<double>{0.5, 0.5});
  const ArrayDynamics some = found_of(0.52, 0.4, 0.8, 40.0);
  CHECK(some.shared.lag_share == Approx(0.46).epsilon(1e-6));
  CHECK(some.lag_share[0] == 0.5);
  CHECK(some.lag_share[1] == Approx(0.4).epsilon(1e-6));
  // A taxel that runs ahead of its pressure has no lag; an array that does has none, and keeps its time.
  const ArrayDynamics ahead = found_of(-0.02, 0.1, 0.8, 40.0);
  CHECK(ahead.shared.lag_share == Approx(0.04).epsilon(1e-6));
  CHECK(ahead.lag_share[0] == 0.0);
  const ArrayDynamics none = found_of(-0.1, -0.05, 0.8, 40.0);
  CHECK(none.shared.lag_share == 0.0);
  CHECK(none.shared.lag_s == 1.0);
  CHECK(none.lag_share == std::vector<double>{0.0, 0.0});
  // Longer than the longest that is tried, 0.1 x 1.1^50 s, and shorter than the shortest.
  d.lag_s = 60.0;
  CHECK(found_of(0.1, 0.1, 3.0, 600.0).shared.lag_s == lag_time(50));
  d.lag_s = 0.02;
  CHECK(found_of(0.1, 0.1, 0.05, 5.0).shared.lag_s == lag_time(0));
}

TEST_CASE("lag search: equal outputs at both rates give no lag", "[dynamic]") {
  const ArrayDynamics found =
      lag_of({}, {{0.0, 0.1, 1.0, 0.0}, {0.0, 0.2, 1.0, 0.0}}, {{"rate", {{kUpAndDown, 1.0}, {kUpAndDown, 20.0}}}});
  CHECK(found.rate_samples == 4);
  CHECK(found.shared.lag_share == Approx(0.0).margin(1e-9));
  for (const double share : found.lag_share) CHECK(share == Approx(0.0).margin(1e-9));
  const ArrayDynamics none = find_dynamics(nullptr, nullptr, {0.0, 0.0}, {true, true});
  CHECK(none.shared.creep_share == std::array<double, kCreepElements>{});
  CHECK(none.lag_share == std::vector<double>{0.0, 0.0});
}

TEST_CASE("lag search: an uncertain taxel's share is pulled toward the array's, an unusable taxel gets the array's",
          "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.04}, {0.0, 0.1, 1.0, 0.08}, {0.0, 0.1, 1.0, 0.2}};
  Dataset data = walked_run(d, taxels, {{"rate", {{kUpAndDown, 0.8}, {kUpAndDown, 60.0}}}}, 30.0);
  // What is still to come in the fast repeat, times the slope of 0.1 V/psi, is what the shares are counted in. The slow
  // one waits for 60 s, more than 60 lags: nothing is left.
  std::vector<double> x;
  double late = 0.0;
  for (const double psi : kUpAndDown) {
    late = psi + (late - psi) * std::exp(-0.8 / d.lag_s);
    x.push_back(0.1 * (late - psi));
  }
  // Errors of the first two taxels that the regression does not see, since they are at right angles to x, and the mean
  // neither, since their signs differ.
  constexpr double kError = 0.2;
  std::vector<double>& volts = data.sequences[0].repeats[0].volts;
  volts[1 * 3 + 0] += kError * x[2];
  volts[2 * 3 + 0] -= kError * x[1];
  volts[1 * 3 + 1] -= kError * x[2];
  volts[2 * 3 + 1] += kError * x[1];
  ArrayDynamics found = nothing_known(3);
  find_lag(data, {0.0, 0.0, 0.0}, {true, true, false}, found);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.shared.lag_share == Approx(0.06).epsilon(1e-6));
  // Of four samples: the errors' mean square over the sum of x^2, against 0.3 of the share, 0.018, squared.
  const double xx = x[1] * x[1] + x[2] * x[2] + x[4] * x[4] + x[5] * x[5];
  const double rest = kError * kError * (x[1] * x[1] + x[2] * x[2]), doubt2 = rest / 4.0 / xx;
  const double kept = 0.018 * 0.018 / (0.018 * 0.018 + doubt2);
  REQUIRE((kept > 0.01 && kept < 0.9));
  CHECK(found.lag_share[0] == Approx(0.06 - 0.02 * kept).epsilon(1e-6));
  CHECK(found.lag_share[1] == Approx(0.06 + 0.02 * kept).epsilon(1e-6));
  CHECK(found.lag_share[2] == found.shared.lag_share);
}
