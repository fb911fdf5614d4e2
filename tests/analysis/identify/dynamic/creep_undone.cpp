// A model's lag and creep taken back from runs and tables that its formulas made.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/dynamic/own_creep.h"
#include "analysis/identify/dynamic/undone.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

Dynamics some_dynamics() {
  Dynamics d;
  d.creep_s = {2.0, 20.0, 200.0};
  d.creep_share = {0.05, 0.03, 0.02};
  d.creep_half = 6.0;
  d.lag_s = 1.5;
  d.lag_share = 0.2;
  return d;
}

// Cells (0,0) 1, (1,0) 1, (1,1) 1 over low..low + 60.
std::shared_ptr<const HysteresisModel> two_interval_film(const Divider& divider, double low = 0.0, double y_low = 0.0,
                                                         std::vector<double> weights = {1, 1, 1}) {
  return std::make_shared<LinearisedModel>(divider,
                                           std::make_shared<PreisachModel>(low, low + 60.0, y_low, std::move(weights)));
}

ModelTaxel film_taxel(int number, std::shared_ptr<const HysteresisModel> film) {
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::move(film);
  return taxel;
}

SensorModel model_with(const Dynamics& d, std::vector<ModelTaxel> taxels) {
  SensorModel model;
  model.source = "run 7";
  model.dynamics = SensorDynamics{};
  model.dynamics->shared = d;
  model.taxels = std::move(taxels);
  return model;
}

// Inputs 10 + p at times, and outputs zero + volts x the creep's factor, of one way; moves the state along.
History creeping_history(const Dynamics& d, DynamicsState& state, double scale, double zero,
                         const std::vector<double>& psi, double begin_s, double seconds, bool first_counts) {
  History history;
  for (std::size_t i = 0; i < psi.size(); ++i) {
    const DynamicsStep step(d, i == 0 && !first_counts ? 0.0 : seconds);
    history.x.push_back(10.0 + psi[i]);
    history.y.push_back(zero + (1.0 + static_cast<double>(i)) * creep_factor(d, state, step, psi[i], scale));
    history.time_s.push_back(begin_s + seconds * static_cast<double>(i + 1));
    history.held_s.push_back(seconds);
    advance(d, state, step, psi[i]);
  }
  return history;
}

std::vector<double> arrived_of(const Dynamics& d, DynamicsState state, double share, const std::vector<double>& psi,
                               double seconds, bool first_counts) {
  std::vector<double> x;
  for (std::size_t i = 0; i < psi.size(); ++i) {
    const DynamicsStep step(d, i == 0 && !first_counts ? 0.0 : seconds);
    x.push_back(10.0 + arrived(share, state, step, psi[i]));
    advance(d, state, step, psi[i]);
  }
  return x;
}

void check_close(const std::vector<double>& own, const std::vector<double>& by_hand) {
  REQUIRE(own.size() == by_hand.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    CAPTURE(i);
    CHECK(own[i] == Approx(by_hand[i]).epsilon(1e-9).margin(1e-9));
  }
}

const std::vector<double> kRisesAndFalls{0, 20, 60, 30, 10};

}  // namespace

TEST_CASE("a run with lag and creep undone has straight outputs at the pressures that have arrived", "[dynamic]") {
  const Dynamics d = some_dynamics();
  const std::vector<WalkedTaxel> taxels = {{0.1, 0.05, 2.0, d.lag_share}, {0.3, 0.02, 0.5, d.lag_share}};
  const Dataset run = walked_run(
      d, taxels,
      {{"a", {{kRisesAndFalls, 2.0}, {kRisesAndFalls, 1.0, 30.0}}}, {"b", {{kRisesAndFalls, 3.0, 0.0, 0.5}}}}, 60.0);
  ArrayDynamics known;
  known.shared = d;
  known.creep_scale = {2.0, 0.5};
  known.lag_share = {0.0, 0.0};
  const Dataset undone = lag_and_creep_undone(run, known, {0.1, 0.3}, 60.0);
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t r = 0; r < run.sequences[s].repeats.size(); ++r) {
      const Repeat &own = undone.sequences[s].repeats[r], &measured = run.sequences[s].repeats[r];
      for (std::size_t i = 0; i < kRisesAndFalls.size(); ++i) {
        CAPTURE(s, r, i);
        CHECK(own.volts[2 * i] == Approx(0.1 + 0.05 * own.steps[i].reference_psi));
        CHECK(own.volts[2 * i + 1] == Approx(0.3 + 0.02 * own.steps[i].reference_psi));
        CHECK(own.steps[i].setpoint_psi == kRisesAndFalls[i]);
        CHECK(own.steps[i].time_s == measured.steps[i].time_s);
      }
    }
  // At the second level, 2 s after 0: 20 less a fifth of what a lag of 1.5 s still keeps.
  CHECK(undone.sequences[0].repeats[0].steps[1].reference_psi == Approx(20.0 - 0.2 * 20.0 * std::exp(-2.0 / 1.5)));
}

TEST_CASE("histories of a run are undone one after the other, conditioning included, those of a table each from rest",
          "[dynamic]") {
  const Dynamics d = some_dynamics();
  ModelTaxel taxel = film_taxel(3, two_interval_film({0.1, 0.0}, 10.0, 0.05));
  taxel.zero = 0.02;
  taxel.gain = 2.0;
  taxel.creep_scale = 1.5;
  taxel.lag_share = 0.3;
  const SensorModel model = model_with(d, {film_taxel(1, two_interval_film({0.0, 0.0}, 10.0)), taxel});
  const double zero = 0.02 + 2.0 * 0.15;
  std::vector<double> volts;
  for (std::size_t i = 0; i < kRisesAndFalls.size(); ++i) volts.push_back(zero + 1.0 + static_cast<double>(i));
  for (const bool run : {true, false}) {
    CAPTURE(run);
    Histories histories;
    histories.run = run ? 5 : 0;
    TaxelHistories own;
    own.taxel = 3;
    DynamicsState state;
    own.score.push_back(creeping_history(d, state, 1.5, zero, kRisesAndFalls, 0.0, 2.0, run));
    // Of a run 40 s of conditioning before the second.
    if (run) work_unseen(d, state, 40.0, 60.0);
    if (!run) state = {};
    const DynamicsState second = state;
    own.score.push_back(creeping_history(d, state, 1.5, zero, kRisesAndFalls, 10.0 + 40.0, 1.0, run));
    if (!run) own.score[1].held_s.clear();
    TaxelHistories stranger = own;
    stranger.taxel = 9;
    histories.taxels = {own, stranger};
    const Histories undone = creep_and_lag_undone(model, histories);
    check_close(undone.taxels[0].score[0].y, volts);
    check_close(undone.taxels[0].score[1].y, volts);
    check_close(undone.taxels[0].score[0].x, arrived_of(d, {}, 0.3, kRisesAndFalls, 2.0, run));
    check_close(undone.taxels[0].score[1].x, arrived_of(d, second, 0.3, kRisesAndFalls, 1.0, run));
    CHECK(undone.taxels[1].score[0].y == own.score[0].y);
    CHECK(undone.taxels[1].score[1].x == own.score[1].x);
    Histories timeless = histories;
    timeless.taxels[1].score[1].time_s.pop_back();
    CHECK_THROWS_AS(creep_and_lag_undone(model, timeless), AnalysisError);
    // Nothing to undo: nothing is touched, nor asked for.
    SensorModel still = model;
    still.dynamics->shared.creep_share = {};
    still.dynamics->shared.lag_share = 0.0;
    CHECK(creep_and_lag_undone(still, timeless).taxels[0].score[0].y == own.score[0].y);
    still.taxels[1].status = TaxelStatus::kUnfit;
    still.dynamics = model.dynamics;
    CHECK(creep_and_lag_undone(still, histories).taxels[0].score[0].y == own.score[0].y);
  }
}
