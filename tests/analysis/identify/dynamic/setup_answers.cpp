// What a dynamic compensator takes of a sensor's model, and what of lag and creep a model undoes: by hand.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/dynamic_setup_of.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench::analysis;

namespace {

// Two intervals from 10 to 50 psi: cells of 1, 2 and 4 V, from `low` on, with a divider.
ModelTaxel film_taxel(int number, double per_amplitude, double low, double x_high = 50.0) {
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  taxel.noise = 0.002;
  taxel.creep_scale = 1.5;
  taxel.lag_share = 0.25;
  taxel.residual_psi = 0.75;
  const auto film = std::make_shared<PreisachModel>(10.0, x_high, low, std::vector<double>{1, 2, 4});
  taxel.fit.model = std::make_shared<LinearisedModel>(Divider{0.5, per_amplitude}, film);
  return taxel;
}

SensorModel of_films(std::vector<ModelTaxel> taxels) {
  SensorModel model;
  model.source = "run 5";
  model.dynamics.emplace();
  model.dynamics->shared.lag_s = 3.0;
  model.dynamics->residual_shape = {1, 2, 3, 4};
  model.taxels = std::move(taxels);
  return model;
}

std::string setup_refusal(const SensorModel& model) {
  try {
    (void)dynamic_setup_of(model, model.taxels, 1.0, 1.0);
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-COMPENSATOR");
    const std::string what = error.what();
    const std::size_t at = what.find("taxel ");
    REQUIRE(at != std::string::npos);
    return what.substr(at, what.find(':', at) - at);
  }
  return {};
}

}  // namespace

TEST_CASE("a dynamic compensator's setup by hand: Everett's table, divider and noise of an adjusted taxel",
          "[dynamic]") {
  SensorModel model = of_films({film_taxel(0, 0.125, 0.0), ModelTaxel(), film_taxel(2, 0.0, 0.75)});
  model.taxels[0].zero = 1.0;
  model.taxels[0].gain = 2.0;
  model.falling = true;
  const DynamicSetup setup = dynamic_setup_of(model, model.taxels, 0.5, 3.0);
  CHECK((setup.x_low == 10.0 && setup.x_high == 50.0 && setup.intervals == 2 && setup.volts_per_count == 0.5));
  CHECK((setup.dynamics.lag_s == 3.0 && setup.residual_psi == std::vector<double>{1, 2, 3, 4}));
  REQUIRE(setup.taxels.size() == 3);
  const DynamicTaxel &first = setup.taxels[0], &last = setup.taxels[2];
  CHECK((first.usable && !setup.taxels[1].usable && last.usable));
  CHECK((first.noise_v == Approx(0.006) && first.creep_scale == 1.5 && first.lag_share == 0.25));
  CHECK((first.residual_scale == 0.75 && first.falling));
  CHECK(first.divider.zero == 2.0);  // 1 + 2 x 0.5
  CHECK(first.divider.per_amplitude == 0.0625);
  CHECK((last.divider.zero == 1.25 && last.divider.per_amplitude == 0.0));  // its film's own zero counts
  // Rises to 30 psi from 10; to 50 from 10 and from 30: of the cells (0,0) = 1, (1,0) = 2, (1,1) = 4.
  REQUIRE(last.everett.size() == 6);
  CHECK(last.everett == std::vector<double>{0, 1, 0, 7, 4, 0});
  CHECK(first.everett == std::vector<double>{0, 2, 0, 14, 8, 0});
}

TEST_CASE("a dynamic compensator is refused where the models do not carry it, each for what it is", "[dynamic]") {
  CHECK(setup_refusal(of_films({film_taxel(0, 0.125, 0.0), film_taxel(1, 0.125, 0.0)})).empty());
  SensorModel none = of_films({film_taxel(4, 0.125, 0.0)});
  none.dynamics.reset();
  CHECK(setup_refusal(none) == "taxel 4");
  none.taxels.clear();
  CHECK(setup_refusal(none) == "taxel 0");
  CHECK(setup_refusal(of_films({ModelTaxel()})) == "taxel 0");
  ModelTaxel plain = straight_array::straight_taxel(20.0);
  plain.taxel = 6;
  CHECK(setup_refusal(of_films({plain})) == "taxel 6");
  CHECK(setup_refusal(of_films({film_taxel(0, 0.125, 0.0), film_taxel(3, 0.125, 0.0, 49.0)})) == "taxel 3");
  // With a divider the film has to begin at 0, within a billionth of its 7 V.
  CHECK(setup_refusal(of_films({film_taxel(0, 0.125, 6.9e-9)})).empty());
  CHECK(setup_refusal(of_films({film_taxel(0, 0.125, 7.1e-9)})) == "taxel 0");
  CHECK(setup_refusal(of_films({film_taxel(0, 0.125, -7.1e-9)})) == "taxel 0");
  CHECK(setup_refusal(of_films({film_taxel(0, 0.01, 0.5)})) == "taxel 0");
  CHECK(setup_refusal(of_films({film_taxel(0, 0.0, 0.5)})).empty());
}

TEST_CASE("a divider counts from its own zero, whatever little the film begins at", "[dynamic]") {
  const auto zero_of = [](double per_amplitude, double low) {
    const SensorModel model = of_films({film_taxel(0, per_amplitude, low)});
    return dynamic_setup_of(model, model.taxels, 1.0, 1.0).taxels.front().divider.zero;
  };
  CHECK(zero_of(0.125, 1e-9 * 7.0) == 0.5);  // just as little as is taken
  CHECK(zero_of(0.125, -6e-9) == 0.5);
  CHECK(zero_of(0.0, 6e-9) == 0.5 + 6e-9);
}

TEST_CASE("Everett's table of a setup does not fall, though sums of equal weights may round down", "[dynamic]") {
  std::uint64_t state = 5;
  const auto number = [&] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state >> 40U) / 16777216.0;
  };
  int fell = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> weights(21);
    for (double& weight : weights) weight = number() < 0.6 ? 0.0 : number();
    ModelTaxel taxel = film_taxel(0, 0.0, 0.0);
    taxel.gain = 0.3;
    const auto film = std::make_shared<PreisachModel>(10.0, 47.0, 0.0, weights);
    taxel.fit.model = std::make_shared<LinearisedModel>(Divider{0.5, 0.0}, film);
    const SensorModel model = of_films({taxel});
    const std::vector<double> table = dynamic_setup_of(model, model.taxels, 1.0, 1.0).taxels.front().everett;
    REQUIRE(table.size() == 28);
    for (std::size_t i = 1, row = 1; i <= 6; row += ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double high = 10.0 + 37.0 / 6.0 * static_cast<double>(i),
                     low = 10.0 + 37.0 / 6.0 * static_cast<double>(j);
        CAPTURE(trial, i, j);
        CHECK(table[row + j] == Approx(0.3 * film->everett(high, low)).margin(1e-12));
        CHECK(table[row + j] >= table[row + j + 1]);
        if (j + 1 < i) CHECK(table[row + j] >= table[row - i + j]);
        fell += table[row + j] > 0.3 * film->everett(high, low) ? 1 : 0;
      }
  }
  CHECK(fell > 0);
}

TEST_CASE("what of lag and creep a dynamic model undoes", "[dynamic]") {
  const auto with = [](std::array<double, 3> creep, double lag) {
    SensorDynamics dynamics;
    dynamics.shared.creep_share = creep;
    dynamics.shared.lag_share = lag;
    return std::string(undoes_creep(dynamics) ? "c" : "-") + (undoes_lag(dynamics) ? "l" : "-") +
           (in_time(dynamics) ? "t" : "-") + (creep_of_fitted_run(dynamics) ? "o" : "-");
  };
  CHECK(with({0, 0, 0}, 0) == "----");
  CHECK(with({0, 0, 0}, 0.1) == "-lt-");
  CHECK(with({0, 0, 0.1}, 0) == "c-t-");
  CHECK(with({0.1, 0.1, 0.1}, 0) == "c-to");
  CHECK(with({0.1, 0.1, 0.2}, 0.1) == "clt-");
}
