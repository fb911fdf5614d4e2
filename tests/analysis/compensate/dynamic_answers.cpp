// The plain dynamic compensator by hand, on a straight film of one interval: 60 psi are 6 V above 0.5 V.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/compensate/dynamic_compensator.h"
#include "tests/analysis/compensate/straight_setup.h"

using namespace tactbench::analysis;

namespace {

// A creep whose target is 1 under any load, so that no pressure has to be guessed for it.
DynamicSetup creeping_setup() {
  DynamicSetup setup = straight_setup();
  setup.dynamics.creep_s = {2.0, 20.0, 200.0};
  setup.dynamics.creep_share = {0.05, 0.03, 0.02};
  setup.dynamics.creep_half = 1e-9;
  setup.dynamics.lag_s = 1.5;
  setup.taxels[0].creep_scale = 1.5;
  setup.taxels[0].lag_share = 0.2;
  return setup;
}

// The film by the formulas, moved along.
struct CreepingFilm {
  Dynamics d;
  DynamicTaxel taxel;
  DynamicsState state = {};
  double volts(double psi, double seconds) {
    const DynamicsStep step(d, seconds);
    const double out =
        arrived(taxel.lag_share, state, step, psi) / 10.0 * creep_factor(d, state, step, psi, taxel.creep_scale);
    advance(d, state, step, psi);
    return 0.5 + out;
  }
};

double read_at(DynamicTaxelCompensator& compensator, double volts) { return compensator.step(volts, 0.0).pressure_psi; }

}  // namespace

TEST_CASE("dynamic by hand: pressures of a straight film, of a falling one, and where its output ends", "[dynamic]") {
  DynamicSetup setup = straight_setup(0.01);
  setup.x_low = 10.0;  // 50 psi are 6 V
  DynamicTaxelCompensator rising(setup, 0);
  CHECK(read_at(rising, 3.5) == Approx(35.0));
  CHECK(read_at(rising, 1.7) == Approx(20.0));
  DynamicSetup other = setup;
  other.taxels[0].falling = true;
  DynamicTaxelCompensator falling(other, 0);
  CHECK(read_at(falling, -3.5) == Approx(35.0));
  for (const auto& [output, out] : {std::pair{6.05, false}, {6.06, true}, {-0.05, false}, {-0.06, true}}) {
    CAPTURE(output);
    rising.reset();
    CHECK(rising.step(0.5 + output, 0.0).out_of_range == out);
  }
  CHECK(read_at(rising, 9.0) == Approx(60.0));
  rising.reset();
  CHECK(read_at(rising, 0.1) == Approx(10.0));
  for (const double bad : {-1.0, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_AS(rising.step(1.0, bad), std::invalid_argument);
    CHECK_THROWS_AS(rising.work(bad), std::invalid_argument);
    CHECK_THROWS_AS(rising.rest(bad), std::invalid_argument);
  }
  CHECK_NOTHROW(rising.work(0.0));
  CHECK_NOTHROW(rising.rest(0.0));
}

TEST_CASE("dynamic by hand: noise, and what the model leaves of the direction, make the uncertainty", "[dynamic]") {
  DynamicSetup setup = straight_setup(0.01);
  setup.residual_psi = {0.3, 0.7};
  setup.taxels[0].residual_scale = 2.0;
  setup.observer.share = 0.0;
  for (const auto& [flat_psi, flat] : {std::pair{0.39, true}, {0.41, false}}) {
    setup.options.flat_psi = flat_psi;  // four noises of 10 mV are 0.4 psi
    DynamicTaxelCompensator compensator(setup, 0);
    const Compensated up = compensator.step(3.5, 0.0);
    CHECK(compensator.ascending());
    CHECK(up.uncertainty_psi == Approx(std::hypot(0.1, 0.6)));
    CHECK(up.flat == flat);
    const Compensated down = compensator.step(1.5, 0.0);
    CHECK_FALSE(compensator.ascending());
    CHECK(down.uncertainty_psi == Approx(std::hypot(0.1, 1.4)));
  }
}

TEST_CASE("dynamic by hand: a turn within a fiftieth of the top is one at the top, and what the gain changes is doubt",
          "[dynamic]") {
  DynamicSetup setup = straight_setup();
  setup.residual_psi = {0.0, 0.0};
  DynamicTaxelCompensator compensator(setup, 0);
  const auto turn_at = [&](double output) {
    (void)compensator.step(0.5 + output, 0.0);
    return compensator.step(0.5 + 3.0, 0.0);
  };
  CHECK(turn_at(5.87).pressure_psi == Approx(30.0));
  CHECK(compensator.gain() == 1.0);
  const Compensated once = turn_at(5.94);
  CHECK(compensator.gain() == Approx(6.0 / 5.94));
  CHECK(once.pressure_psi == Approx(30.0 * 6.0 / 5.94));
  // 5 x the change times half the range.
  CHECK(once.uncertainty_psi == Approx(5.0 * (6.0 / 5.94 - 1.0) * 30.0));
  CHECK(compensator.step(0.5 + 2.97, 0.0).pressure_psi == Approx(30.0));
  // A lower one moves the highest by a fiftieth of the way, a higher one at once.
  (void)turn_at(5.90);
  CHECK(compensator.gain() == Approx(6.0 / (5.94 - 0.02 * 0.04)));
  (void)turn_at(5.97);
  CHECK(compensator.gain() == Approx(6.0 / 5.97));
  (void)turn_at(6.3);
  CHECK(compensator.gain() == Approx(6.0 / 6.3));
  (void)turn_at(7.0);
  CHECK(compensator.gain() == Approx(1.0 / 1.1));  // by a tenth at most
  compensator.reset();
  CHECK(compensator.gain() == 1.0);
  CHECK(read_at(compensator, 3.5) == Approx(30.0));
}

TEST_CASE("dynamic by hand: creep and lag are undone along steps, rest, conditioning and a start after it",
          "[dynamic]") {
  for (const bool creeps : {true, false}) {
    CAPTURE(creeps);
    DynamicSetup setup = creeping_setup();
    setup.worked_s = 30.0;
    if (creeps) setup.taxels[0].lag_share = 0.0;
    if (!creeps) setup.dynamics.creep_share = {};
    DynamicTaxelCompensator compensator(setup, 0);
    CreepingFilm film{setup.dynamics, setup.taxels[0]};
    const auto go = [&](const std::vector<double>& way, double seconds) {
      for (const double psi : way) {
        CAPTURE(psi, seconds);
        CHECK(compensator.step(film.volts(psi, seconds), seconds).pressure_psi == Approx(psi).margin(1e-6));
      }
    };
    work_unseen(setup.dynamics, film.state, 30.0, 60.0);
    go({0, 30, 30, 50}, 5.0);
    go({20, 10, 40}, 1.0);
    go({0}, 5.0);
    compensator.rest(20.0);
    advance(setup.dynamics, film.state, {setup.dynamics, 20.0}, 0.0);
    go({0, 30, 45}, 5.0);
    go({0}, 2.0);
    compensator.work(40.0);
    work_unseen(setup.dynamics, film.state, 40.0, 60.0);
    go({0, 55, 5}, 3.0);
    compensator.reset();
    film.state = {};
    work_unseen(setup.dynamics, film.state, 30.0, 60.0);
    go({0, 25}, 3.0);
  }
}
