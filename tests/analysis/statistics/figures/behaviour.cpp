// Raw behaviour against hand-made loops whose figures are known.
#include "analysis/statistics/figures/behaviour.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tactbench::analysis;

namespace {

constexpr double kStaircase[] = {0.0, 20.0, 40.0, 60.0, 40.0, 20.0, 0.0};

// Three taxels and one that does not count. Taxel t: up g p / 60, down g (p / 60 + h x (1 - x) x 4), x = p / 60, so
// that the distance is h of full scale at 30 psi; repeat r adds r millivolt above 0 psi, and each repeat ends 2 mV
// (taxel 1: 6 mV) above its start.
constexpr double kGain[] = {3.0, 2.0, 4.0, 0.0};
constexpr double kGap[] = {0.09, 0.18, 0.36, 0.0};

Dataset known_loops(int repeats) {
  Dataset dataset;
  dataset.run = 7;
  dataset.rows = 1;
  dataset.columns = 4;
  dataset.noise_v.assign(4, 0.0);
  dataset.at_limit.assign(4, false);
  SequenceData sequence{"loop", {}};
  for (int r = 0; r < repeats; ++r) {
    Repeat repeat;
    for (std::size_t i = 0; i < std::size(kStaircase); ++i) {
      const double p = kStaircase[i], x = p / 60.0;
      repeat.steps.push_back({p, p});
      for (std::size_t t = 0; t < 4; ++t) {
        double v = kGain[t] * (x + (i > 3 ? kGap[t] * 4.0 * x * (1.0 - x) : 0.0));
        if (i > 0 && i < 6) v += 0.001 * r;
        if (i == 6) v += t == 1 ? 0.006 : 0.002;
        repeat.volts.push_back(v);
      }
    }
    sequence.repeats.push_back(repeat);
  }
  dataset.sequences = {sequence};
  return dataset;
}

}  // namespace

TEST_CASE("loops are ranked by hysteresis error, gains are shares of the mean that counts") {
  const Behaviour b = behaviour_of(known_loops(1), {0, 1, 2});
  CHECK(b.pressure_psi == std::vector<double>{0, 20, 40, 60});
  REQUIRE(b.loops.size() == 4);
  CHECK(b.loops[0].name == "mean");
  CHECK(b.loops[1].taxel == 0);
  CHECK(b.loops[2].taxel == 1);
  CHECK(b.loops[3].taxel == 2);
  // 4 x (1 - x) is 8/9 at both inner levels.
  CHECK(b.loops[1].hysteresis_max == Approx(0.09 * 8.0 / 9.0));
  CHECK(b.loops[1].hysteresis_mean == Approx((2.0 * 0.09 * 8.0 / 9.0 + 0.002 / 3.0) / 4.0));
  CHECK(b.loops[0].full_scale_v == Approx(3.0));
  CHECK(b.loops[0].hysteresis_max == Approx((3 * 0.09 + 2 * 0.18 + 4 * 0.36) / 9.0 * 8.0 / 9.0));
  CHECK(b.equilibration_psi == 40.0);
  CHECK(b.gain[0] == Approx(1.0));
  CHECK(b.gain[1] == Approx(2.0 / 3.0));
  CHECK(b.gain[2] == Approx(4.0 / 3.0));
  CHECK(std::isnan(b.gain[3]));
  CHECK(std::isnan(b.hysteresis_max[3]));
  CHECK(b.repeatability.empty());
  CHECK(b.creep.empty());
  REQUIRE(b.traces.size() == 1);
  CHECK(b.traces[0].output_v[1] == Approx(1.0));
}

TEST_CASE("repeatability is the standard deviation over the repeats, zero return that of single ends") {
  const Behaviour b = behaviour_of(known_loops(3), {0, 1, 2});
  CHECK(b.repeats == 3);
  REQUIRE(b.repeatability.size() == 4);
  CHECK(b.repeatability[1].mean_up_v == Approx(0.001));  // of 0, 1, 2 mV
  CHECK(b.repeatability[2].taxel_down_v == Approx(0.001));
  CHECK(b.repeatability[0].mean_up_v == Approx(0.0).margin(1e-12));
  REQUIRE(b.zero_returns.size() == 1);
  CHECK(b.zero_returns[0].repeats == 3);
  CHECK(b.zero_returns[0].mean_v == Approx((0.002 + 0.006 + 0.002) / 3.0));
  CHECK(b.zero_returns[0].worst_taxel == 1);
  CHECK(b.zero_returns[0].worst_taxel_v == Approx(0.006));
}

TEST_CASE("a run without a full sweep has zero return and creep, but no loop") {
  Dataset dataset;
  dataset.run = 9;
  dataset.rows = dataset.columns = 1;
  dataset.noise_v = {0.0};
  dataset.at_limit = {false};
  Repeat repeat;
  double time = 0.0;
  const auto sample = [&](double pressure, double volts, double held) {
    repeat.steps.push_back({pressure, pressure, time, held});
    repeat.volts.push_back(volts);
  };
  sample(40.0, 2.0, 2.0);
  for (int i = 1; i <= 100; ++i) {
    time += 2.0;
    sample(40.0, 2.0 + 0.02 * std::log10((2.0 + time) / 2.0), 2.0);
  }
  dataset.sequences = {{"creep-hold", {repeat}}};
  const std::vector<Creep> creep = creep_of(dataset, {0});
  REQUIRE(creep.size() == 1);
  CHECK(creep[0].run == 9);
  CHECK(creep[0].samples == 101);
  CHECK(creep[0].from_s == 2.0);
  CHECK(creep[0].to_s == 202.0);
  CHECK(creep[0].per_decade == Approx(0.01));  // 20 mV of 2 V a decade
  CHECK(creep[0].per_decade_u < 1e-9);
  const Behaviour b = behaviour_of(dataset, {0});
  CHECK(b.loops.empty());
  CHECK(b.zero_returns.empty());
  CHECK(b.creep.size() == 1);
  repeat.steps.resize(19);
  repeat.volts.resize(19);
  dataset.sequences = {{"creep-hold", {repeat}}};
  CHECK(creep_of(dataset, {0}).empty());  // too few
  CHECK_THROWS_AS(behaviour_of(dataset, {}), std::invalid_argument);
}
