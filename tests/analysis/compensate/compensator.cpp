#include "analysis/compensate/compensator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

// The first taxel of the synthetic array: its falling curve loses 1-2 % of full scale from 60 down to 50 psi.
ElamModel sloping_taxel() {
  ArrayOptions options;
  options.rows = options.columns = 1;
  ElamModel model = Array(options).taxels.front();
  model.options.exact_outer = false;
  return model;
}

}  // namespace

TEST_CASE("without noise the compensator gives the pressure back along both sequences of Table 1") {
  const ElamModel model = sloping_taxel();
  Plant plant(model);
  TaxelCompensator compensator(model, {});
  for (const auto& turns : {kDescendingTurns, kAscendingTurns})
    for (const double pressure : levels_of(turns))
      REQUIRE(compensator.step(plant(pressure)).pressure_psi == Approx(pressure).margin(1e-6));
}

TEST_CASE("a held level under noise makes no turn and no bias") {
  const ElamModel model = sloping_taxel();
  const double noise = 0.001;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  struct Hold {
    std::vector<double> way;
    double level, bias_psi;
  };
  for (const Hold& hold : {Hold{{0, 30}, 30.0, 0.25}, Hold{{0, 58}, 58.0, 0.5}, Hold{{0, 60, 54}, 54.0, 0.5}}) {
    Plant plant(model);
    TaxelCompensator compensator(model, {.noise_v = noise});
    for (const double pressure : levels_of(hold.way)) compensator.step(plant(pressure) + noise * normal(random));
    const bool ascending = compensator.ascending();
    double sum = 0.0, worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double off = compensator.step(plant(hold.level) + noise * normal(random)).pressure_psi - hold.level;
      sum += off;
      worst = std::max(worst, std::abs(off));
      REQUIRE(compensator.ascending() == ascending);
    }
    INFO("held at " << hold.level << ": mean " << sum / 2000 << ", worst " << worst << " psi");
    CHECK(std::abs(sum / 2000) < hold.bias_psi);
    CHECK(worst < 4.0);
  }
}

TEST_CASE("outputs slightly lower than at the fit: loading and unloading read within 1.5 % of each other") {
  const ElamModel model = sloping_taxel();
  for (const double gain : {0.998, 0.995, 0.99}) {
    const auto distance = [&](double drift_share) {
      Plant plant(model);
      TaxelCompensator compensator(model, {.noise_v = 0.001, .drift_share = drift_share});
      std::vector<double> estimates;
      for (const double pressure : levels_of({0, 60, 0}))
        estimates.push_back(compensator.step(gain * plant(pressure)).pressure_psi);
      double sum = 0.0;
      for (std::size_t i = 0; i <= 30; ++i) sum += std::abs(estimates[i] - estimates[60 - i]) / 31.0;
      return sum / 60.0;
    };
    INFO("gain " << gain << ": " << distance(0.0) << " without, " << distance(0.01) << " with");
    CHECK(distance(0.01) < 0.015);
    CHECK(distance(0.0) > 0.010);
  }
}

TEST_CASE("values that are not finite are refused and leave the state alone") {
  const ElamModel model = sloping_taxel();
  TaxelCompensator compensator(model, {.noise_v = 0.001}), untouched(model, {.noise_v = 0.001});
  compensator.step(1.0);
  untouched.step(1.0);
  CHECK_THROWS_AS(compensator.step(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  CHECK_THROWS_AS(compensator.step(std::numeric_limits<double>::infinity()), std::invalid_argument);
  CHECK(compensator.step(0.5).pressure_psi == untouched.step(0.5).pressure_psi);
  CHECK_THROWS_AS(TaxelCompensator(model, {.noise_v = -1.0}), std::invalid_argument);
}
