// How far a taxel's own lag is trusted, and what a dynamic compensator takes of a sensor's model: by hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamics_search.h"
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

std::string refused_setup(const SensorModel& model) {
  try {
    (void)dynamic_setup_of(model, model.taxels, 1.0, 1.0);
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-COMPENSATOR");
    const std::string what = error.what(), begin = "the model of run 5 makes no dynamic compensator: ";
    CHECK_THAT(what, Catch::StartsWith(begin));
    return what.substr(begin.size());
  }
  return {};
}

}  // namespace

TEST_CASE("lag: a taxel's own share is drawn toward the array's by its doubt, against a spread of 30 %", "[dynamic]") {
  double lag_s = 0.1;
  for (int i = 0; i < 24; ++i) lag_s *= 1.1;
  const std::vector<double> levels{0, 10, 20, 30, 20, 10, 0};
  // 1 V a psi with 10 % late, and 0.05 V a psi with 4 %: of both together 0.102 of 1.05.
  Dataset data;
  data.rows = 1;
  data.columns = 2;
  SequenceData sequence{"rate", {}};
  double late = 0.0, now = 0.0;
  std::vector<double> fast, slow;  // what is still to come, psi
  for (const double dwell : {1.0, 40.0}) {
    Repeat repeat;
    for (const double psi : levels) {
      now += dwell;
      late = psi + (late - psi) * std::exp(-dwell / lag_s);
      (dwell < 2.0 ? fast : slow).push_back(late - psi);
      repeat.steps.push_back({psi, psi, now, dwell});
      repeat.volts.push_back(psi + 0.10 * (late - psi));
      repeat.volts.push_back(0.05 * (psi + 0.04 * (late - psi)));
    }
    sequence.repeats.push_back(repeat);
  }
  // The second taxel's fast samples at the first two steps err, so that its share stays as it is: e1 x1 + e2 x2 = 0.
  const auto x = [&](std::size_t i) { return 0.05 * (fast[i] - slow[i]); };
  constexpr double kErr = 0.05;
  sequence.repeats[0].volts[2 * 1 + 1] += kErr * x(2);
  sequence.repeats[0].volts[2 * 2 + 1] -= kErr * x(1);
  data.sequences = {sequence};
  double squares = 0.0;
  for (const std::size_t i : {1U, 2U, 4U, 5U}) squares += x(i) * x(i);
  const double doubt2 = kErr * kErr * (x(1) * x(1) + x(2) * x(2)) / 4.0 / squares;
  const double array = 0.102 / 1.05, spread2 = 0.09 * array * array;
  const ArrayDynamics found = find_dynamics(&data, nullptr, {0.0, 0.0}, {true, true});
  CHECK(found.shared.lag_s == Approx(lag_s));
  CHECK(found.shared.lag_share == Approx(array));
  CHECK(found.lag_share[0] == Approx(0.10));
  CHECK(found.lag_share[1] == Approx(array + (0.04 - array) * spread2 / (spread2 + doubt2)));
  CHECK(found.lag_share[1] > 0.05);
}

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
  CHECK(refused_setup(of_films({film_taxel(0, 0.125, 0.0), film_taxel(1, 0.125, 0.0)})).empty());
  SensorModel none = of_films({film_taxel(4, 0.125, 0.0)});
  none.dynamics.reset();
  CHECK(refused_setup(none) == "taxel 4: it has no lag and creep");
  CHECK(refused_setup(of_films({ModelTaxel()})) == "taxel 0: none of its taxels is fitted");
  ModelTaxel plain = straight_array::straight_taxel(20.0);
  plain.taxel = 6;
  CHECK(refused_setup(of_films({plain})) == "taxel 6: it is not Preisach on the linearised output");
  CHECK(refused_setup(of_films({film_taxel(0, 0.125, 0.0), film_taxel(3, 0.125, 0.0, 49.0)})) ==
        "taxel 3: its range or number of intervals is not that of the others");
  // With a divider the film has to begin at 0, within a billionth of its 7 V.
  CHECK(refused_setup(of_films({film_taxel(0, 0.125, 6.9e-9)})).empty());
  CHECK(refused_setup(of_films({film_taxel(0, 0.125, 7.1e-9)})) ==
        "taxel 0: its divider does not count from the unloaded output");
  CHECK(refused_setup(of_films({film_taxel(0, 0.125, -7.1e-9)})) ==
        "taxel 0: its divider does not count from the unloaded output");
  CHECK(refused_setup(of_films({film_taxel(0, 0.01, 0.5)})) ==
        "taxel 0: its divider does not count from the unloaded output");
  CHECK(refused_setup(of_films({film_taxel(0, 0.0, 0.5)})).empty());
}
