// The inverse by any model by hand, on a Preisach model of three cells: up 0, 1, 3 at 0, 30, 60; down 3, 2, 0.
#include "analysis/compensate/inverse_stream.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/compensate/model_compensator.h"
#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

namespace {

PreisachModel three_cells() { return {0.0, 60.0, 0.0, {1, 1, 1}}; }

// From the top down by `back`, then up to 2.5.
double after_going_back(double back, double dead_band) {
  const PreisachModel model = three_cells();
  InverseStream stream(model, dead_band);
  stream.step(3.0);
  stream.step(3.0 - back);
  return stream.step(2.5);
}

}  // namespace

TEST_CASE("inverse stream by hand: up, back on the way from the furthest output, and on as if nothing had been") {
  const PreisachModel model = three_cells();
  InverseStream stream(model, 0.2);
  CHECK(stream.step(0.5) == Approx(15.0));
  CHECK(stream.step(2.0) == Approx(45.0));
  // Back from 45 by 0.1: within a cell the output moves by one over 30 psi.
  CHECK(stream.reads(1.9) == Approx(42.0));
  CHECK(stream.step(1.9) == Approx(42.0));
  CHECK(stream.step(2.0) == Approx(45.0));
  CHECK(stream.step(2.2) == Approx(48.0));
  stream.reset();
  CHECK(stream.step(2.0) == Approx(45.0));
}

TEST_CASE("inverse stream by hand: a turn is remembered beyond the dead band") {
  // 1.19 back from the top is forgotten: the way down from there, 45 psi at 2.5. 1.21 back is a turn at 26.85 psi and
  // 1.79: up from there, 0.105 to 30 psi, then as much again for every 3.15 psi: 2.5 at 48.15 psi.
  CHECK(after_going_back(1.19, 1.2) == Approx(45.0));
  CHECK(after_going_back(1.21, 1.2) == Approx(48.15));
  CHECK(after_going_back(1.21, 0.0) == Approx(48.15));
  const PreisachModel model = three_cells();
  CHECK_NOTHROW(InverseStream(model, 0.0));
  for (const double bad : {-std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(InverseStream(model, bad), std::invalid_argument);
}

TEST_CASE("inverse stream by hand: an unknown start lies midway until both ways are within a hundredth of the range") {
  const PreisachModel model = three_cells();
  InverseStream stream(model, 0.0);
  stream.reset_unknown();
  CHECK(stream.step(2.0) == Approx(37.5));  // 45 going up, 30 coming down
  CHECK(stream.reads(2.0) == Approx(37.5));
  const auto next = [&](double first) {
    stream.reset_unknown();
    stream.step(first);
    return stream.step(1.0);
  };
  // At 0.02 the ways are 0.6 and 0.3 psi, at 0.05 1.5 and 0.75 psi: the latter goes on from there, to 29.25 psi.
  CHECK(next(0.02) == Approx(30.0));
  CHECK(next(0.05) == Approx(0.5 * (30.0 + 29.25)));
  // A value that is none changes nothing.
  CHECK_THROWS_AS(stream.step(std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(stream.step(std::numeric_limits<double>::infinity()), std::invalid_argument);
  CHECK(stream.step(1.0) == Approx(0.5 * (30.0 + 29.25)));
}

TEST_CASE(
    "model compensator by hand: uncertainty and flatness by the inverse four noises off, range by the dead band") {
  const PreisachModel model = three_cells();
  const auto at_two = [&](double noise) {
    ModelCompensator compensator(model, {0.0, 3.0, 0.2}, {.noise_v = noise});
    return compensator.step(2.0);
  };
  // 0.04 less is 1.2 psi less on the way back, 0.04 more 0.6 psi more: the larger over four.
  const Compensated result = at_two(0.01);
  CHECK(result.pressure_psi == Approx(45.0));
  CHECK(result.uncertainty_psi == Approx(0.3));
  CHECK_FALSE(result.flat);
  CHECK_FALSE(at_two(0.0166).flat);  // 1.992 psi
  CHECK(at_two(0.0167).flat);        // 2.004 psi
  CHECK(at_two(0.0).uncertainty_psi == 0.0);
  CHECK_FALSE(at_two(0.0).flat);
  for (const auto& [output, out] : {std::pair{3.19, false}, {3.21, true}, {-0.19, false}, {-0.21, true}}) {
    INFO(output);
    ModelCompensator compensator(model, {0.0, 3.0, 0.2}, {});
    CHECK(compensator.step(output).out_of_range == out);
  }
  ModelCompensator compensator(model, {0.0, 3.0, 0.2}, {});
  for (const double output : {2.0, 3.0, 1.0}) compensator.step(output);
  compensator.reset();
  CHECK(compensator.step(1.0).pressure_psi == Approx(30.0));
  CHECK_THROWS_AS(ModelCompensator(model, {0.0, 3.0, 0.2}, {.noise_v = -1.0}), std::invalid_argument);
}
