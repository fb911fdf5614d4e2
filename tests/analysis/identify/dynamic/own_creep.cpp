// The creep that one run tells, on straight films whose creep is known.
#include "analysis/identify/dynamic/own_creep.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

// A straight film that goes to and fro for 12 minutes.
Dataset passes(double share, double slowest_s, const std::vector<WalkedTaxel>& taxels) {
  Dynamics d;
  d.creep_s = creep_times(slowest_s);
  d.creep_share.fill(share);
  d.creep_half = 5.0;
  std::vector<double> way;
  const std::vector<double> turns{0,  20, 40, 60, 40, 20, 40, 60, 40, 60, 40, 20, 0,
                                  20, 40, 20, 0,  20, 0,  20, 40, 20, 40, 60, 40, 20};
  for (int n = 0; n < 5; ++n) way.insert(way.end(), turns.begin(), turns.end());
  way.push_back(0.0);
  return walked_run(d, taxels, {{"passes", {{way, 6.0}}}}, 60.0);
}

FitOptions three_cells() {
  FitOptions fit;
  fit.model = "preisach";
  fit.identify.cells = 3;
  fit.identify.linearise = true;
  fit.identify.by_input = true;
  return fit;
}

}  // namespace

TEST_CASE("relaxation times lie evenly over the logarithm of time, from 3 s to the slowest", "[dynamic]") {
  const auto times = creep_times(300.0);
  CHECK(times[0] == 3.0);
  CHECK(times[1] == Approx(30.0));
  CHECK(times[2] == Approx(300.0));
  CHECK(creep_times(12.0)[1] == Approx(6.0));
}

TEST_CASE("slowest times are tried that end within half of the run", "[dynamic]") {
  const auto tried = [](double last_s) {
    Dataset data = walked_run({}, {{0.0, 0.1, 1.0, 0.0}}, {{"a", {{{0, 60, 0}, 1.0}, {{0, 60, 0}, 1.0}}}}, 60.0);
    data.sequences[0].repeats[1].steps.back().time_s = last_s;
    return CreepMisfit(data, {0.0}, {true}, 60.0, three_cells()).slowest_s();
  };
  CHECK(tried(599.0).empty());
  CHECK(tried(600.0) == std::vector<double>{300.0});
  CHECK(tried(2000.0) == std::vector<double>{300.0, 1000.0});
  CHECK(tried(5999.0) == std::vector<double>{300.0, 1000.0});
  CHECK(tried(6000.0) == std::vector<double>{300.0, 1000.0, 3000.0});
  CHECK(tried(20000.0) == std::vector<double>{300.0, 1000.0, 3000.0, 10000.0});
}

TEST_CASE("a run's misfit is none where its creep is undone, and the same whatever the volts", "[dynamic]") {
  const Dataset data = passes(0.04, 300.0, {{0.1, 0.05, 1.0, 0.0}, {5.0, 3.0, 1.0, 0.0}, {0.3, 0.03, 1.0, 0.0}});
  const CreepMisfit misfit(data, {0.1, 5.0, 0.3}, {true, false, true}, 60.0, three_cells());
  Dynamics truth;
  truth.creep_s = creep_times(300.0);
  truth.creep_share.fill(0.04);
  truth.creep_half = 5.0;
  const double without = misfit({});
  CHECK(misfit(truth) < 1e-6 * without);
  const Dataset ten_times = passes(0.04, 300.0, {{1.0, 0.4, 1.0, 0.0}});
  CHECK(CreepMisfit(ten_times, {1.0}, {true}, 60.0, three_cells())({}) == Approx(without).epsilon(1e-4));
  // Without a loop there is no model.
  Dataset flat = data;
  for (Sample& sample : flat.sequences[0].repeats[0].steps) sample.setpoint_psi = 20.0;
  CHECK(CreepMisfit(flat, {0.1, 5.0, 0.3}, {true, false, true}, 60.0, three_cells())({}) ==
        std::numeric_limits<double>::infinity());
}

TEST_CASE("a run tells its creep: the share, no more than 0.16, and none where it helps little", "[dynamic]") {
  const auto told = [](double share) {
    const Dataset data = passes(share, 300.0, {{0.1, 0.05, 1.0, 0.0}});
    return creep_of_one_run(CreepMisfit(data, {0.1}, {true}, 60.0, three_cells()));
  };
  for (const double share : {0.004, 0.01, 0.017, 0.04, 0.053, 0.11}) {
    const Dynamics own = told(share);
    CAPTURE(share);
    CHECK(own.creep_s[2] == Approx(300.0));
    CHECK(own.creep_half == 5.0);
    CHECK(own.creep_share[0] == Approx(share).margin(0.0015));
    CHECK(own.creep_share[1] == own.creep_share[0]);
    CHECK(own.creep_share[2] == own.creep_share[0]);
  }
  CHECK(told(0.25).creep_share[0] == Approx(0.16));
  const Dynamics none = told(0.0);
  CHECK(none.creep_share == std::array<double, kCreepElements>{});
  CHECK(none.creep_half == 10.0);
}
