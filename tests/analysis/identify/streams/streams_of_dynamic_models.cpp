// Streams of a taxel whose model has lag and creep, and what it is measured by.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/undone.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/creeping_film.h"

using namespace tactbench::analysis;
using tactbench::creeping::creeping_film;

TEST_CASE("streams of dynamic models: outputs are given as they rise, and only fitted taxels have lag and creep",
          "[dynamic]") {
  const SensorModel rising = creeping_film(), falling = creeping_film(true);
  const auto one = compensator_of(rising, rising.taxels[0]), other = compensator_of(falling, falling.taxels[0]);
  for (const auto& [volts, seconds] :
       {std::pair{1.0, 0.0}, {2.5, 2.0}, {2.2, 5.0}, {1.5, 1.0}, {2.0, 8.0}, {3.5, 3.0}}) {
    const Compensated a = one->step(volts, seconds), b = other->step(volts, seconds);
    CHECK((a.pressure_psi == b.pressure_psi && a.uncertainty_psi == b.uncertainty_psi));
  }
  SensorModel unfit = creeping_film();
  unfit.taxels[0].status = TaxelStatus::kUnfit;
  const auto still = compensator_of(unfit, unfit.taxels[0]);
  // Half of the first cell: 1 V / 2 behind the divider; time changes nothing.
  const double volts = 0.5 + 0.5 / (1.0 + 0.5 / 8.0);
  for (const double seconds : {0.0, 100.0}) {
    CHECK(still->step(volts, seconds).pressure_psi == Approx(20.0));
    still->work(5.0);
  }
  still->rest(5.0);
  CHECK(still->step(volts, 0.0).pressure_psi == Approx(20.0));
}

TEST_CASE("streams of dynamic models: a taxel is read alone, whatever the ranges of those beside it", "[dynamic]") {
  SensorModel model = creeping_film();
  for (const double high : {60.0, 70.0}) {
    model.taxels.push_back(model.taxels[0]);
    model.taxels.back().taxel = static_cast<int>(model.taxels.size()) - 1;
    model.taxels.back().fit.model = std::make_shared<LinearisedModel>(
        Divider{0.5, 0.125}, std::make_shared<PreisachModel>(10.0, high, 0.0, std::vector<double>{1, 2, 4}));
  }
  // At the end of all cells, 7 V behind the divider, at the far end of each one's own range.
  const double full = 0.5 + 7.0 / (1.0 + 7.0 / 8.0) * 0.94;
  Histories histories;
  for (std::size_t t = 0; t < 3; ++t) {
    CAPTURE(t);
    CHECK(compensator_of(model, model.taxels[t])->step(full, 0.0).pressure_psi > 45.0);
    TaxelHistories& own = histories.taxels.emplace_back();
    own.taxel = static_cast<int>(t);
    own.score = {{"a", {10, 30}, {0.5, 2.0}, {}, {0.0, 1.0}, {0.0, 1.0}}};
  }
  const Histories undone = creep_and_lag_undone(model, histories);
  for (std::size_t t = 0; t < 3; ++t) {
    CHECK(undone.taxels[t].score[0].y[0] == Approx(0.5));
    CHECK(undone.taxels[t].score[0].y[1] > 2.0);
    CHECK(undone.taxels[t].score[0].x[1] < 30.0);
  }
}

TEST_CASE(
    "streams of models without time: a sample is within range to a twentieth or its dead band beyond the film's "
    "outputs") {
  SensorModel model = creeping_film();
  model.dynamics.reset();
  ModelTaxel& taxel = model.taxels[0];
  taxel.fit.model = std::make_shared<PreisachModel>(10.0, 50.0, 0.5, std::vector<double>{1, 2, 4});
  taxel.fit.full_scale = 7.0;
  taxel.zero = 1.0;
  taxel.gain = 2.0;  // outputs from 2 to 16 V
  for (const auto& [noise, noisier, band] : {std::tuple(0.0, 1.0, 0.7), {0.125, 1.0, 0.7}, {0.125, 2.0, 1.375}}) {
    taxel.noise = noise;
    CAPTURE(noise, noisier);
    const auto out = [&, more = noisier](double volts) {
      return compensator_of(model, taxel, more)->step(volts, 0.0).out_of_range;
    };
    CHECK_FALSE(out(16.0 + band - 0.01 * band));
    CHECK(out(16.0625 + band));
    CHECK_FALSE(out(2.0 - band + 0.01 * band));
    CHECK(out(1.9375 - band));
  }
}
