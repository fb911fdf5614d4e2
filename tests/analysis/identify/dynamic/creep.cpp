// The creep of an array from held levels, on outputs that change within each hold as the formula has it: shares, half
// and the taxels' scales come out as they were put in.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

constexpr double kSecondsAFrame = 2.0;
constexpr std::size_t kFrames = 40;  // a level; the first three are within 6 s of its beginning

double half_tried(int k) {
  double half = 1.0;
  for (int i = 0; i < k; ++i) half *= 1.2;
  return half;
}

// Frames of held levels.
Dataset held_levels(const std::vector<double>& levels, std::size_t taxels, std::size_t frames = kFrames) {
  Dataset data;
  data.rows = 1;
  data.columns = static_cast<int>(taxels);
  Repeat repeat;
  double now = 0.0;
  for (const double psi : levels)
    for (std::size_t f = 1; f <= frames; ++f) {
      now += kSecondsAFrame;
      repeat.steps.push_back({psi, psi, now, kSecondsAFrame * static_cast<double>(f)});
    }
  repeat.volts.assign(repeat.steps.size() * taxels, 0.0);
  data.sequences.push_back({"creep-levels", {std::move(repeat)}});
  return data;
}

// psi of each element at each frame, from rest, and its mean over the settled frames of each level.
struct Elements {
  std::vector<std::array<double, 3>> psi, mean;
};

Elements elements_along(const std::vector<double>& levels, const Dynamics& d, std::size_t frames = kFrames) {
  Elements all;
  std::array<double, 3> psi{};
  for (const double level : levels) {
    std::array<double, 3> sum{};
    for (std::size_t f = 1; f <= frames; ++f) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double target = level / (level + d.creep_half);
        psi[j] = target + (psi[j] - target) * std::exp(-kSecondsAFrame / d.creep_s[j]);
        if (f > 3) sum[j] += psi[j] / static_cast<double>(frames - 3);
      }
      all.psi.push_back(psi);
    }
    all.mean.push_back(sum);
  }
  return all;
}

struct Truth {
  std::vector<double> levels{20, 40, 10};
  std::vector<double> volts{1.0, 1.6, 0.7};  // mean of each level above zero
  Dynamics d;
};

Truth any_truth(int half) {
  Truth truth;
  truth.d.creep_share = {0.03, 0.02, 0.05};
  truth.d.creep_half = half_tried(half);
  return truth;
}

// Relative change within each level by the creep's formula, `scale` times the array's.
void creep_taxel(Dataset& data, const Truth& truth, std::size_t taxel, double zero, double scale) {
  const Elements all = elements_along(truth.levels, truth.d);
  const auto width = static_cast<std::size_t>(data.columns);
  for (std::size_t i = 0; i < all.psi.size(); ++i) {
    const std::size_t level = i / kFrames;
    double change = 0.0;
    for (std::size_t j = 0; j < 3; ++j) change += truth.d.creep_share[j] * (all.psi[i][j] - all.mean[level][j]);
    data.sequences[0].repeats[0].volts[i * width + taxel] = zero + truth.volts[level] * (1.0 + scale * change);
  }
}

// The mean of 1 + sum k (psi - 1) over all settled frames.
double factor_of(const Truth& truth) {
  const Elements all = elements_along(truth.levels, truth.d);
  double factor = 0.0;
  for (const std::array<double, 3>& mean : all.mean) {
    double own = 1.0;
    for (std::size_t j = 0; j < 3; ++j) own += truth.d.creep_share[j] * (mean[j] - 1.0);
    factor += own / static_cast<double>(all.mean.size());
  }
  return factor;
}

int holds_in(const Dataset& data) {
  ArrayDynamics found = nothing_known(1);
  find_creep(data, {0.0}, {true}, found);
  return found.holds;
}

}  // namespace

TEST_CASE("creep search: recovers the shares, the half pressure and each taxel's scale from the outputs", "[dynamic]") {
  for (const int half : {0, 9, 22}) {
    const Truth truth = any_truth(half);
    Dataset data = held_levels(truth.levels, 3);
    creep_taxel(data, truth, 0, 0.1, 0.8);
    creep_taxel(data, truth, 1, 0.4, 1.2);
    for (std::size_t i = 0; i < data.sequences[0].repeats[0].steps.size(); ++i)
      data.sequences[0].repeats[0].volts[i * 3 + 2] = 100.0 * static_cast<double>(i % 7);  // not usable
    ArrayDynamics found = nothing_known(3);
    find_creep(data, {0.1, 0.4, 0.0}, {true, true, false}, found);
    CAPTURE(half);
    CHECK(found.holds == 3);
    CHECK(found.shared.creep_half == truth.d.creep_half);
    const double factor = factor_of(truth);
    for (std::size_t j = 0; j < 3; ++j)
      CHECK(found.shared.creep_share[j] == Approx(truth.d.creep_share[j] * factor).epsilon(1e-4));
    CHECK(found.creep_scale[0] == Approx(0.8).epsilon(1e-5));
    CHECK(found.creep_scale[1] == Approx(1.2).epsilon(1e-5));
    CHECK(found.creep_scale[2] == 1.0);
  }
}

TEST_CASE("creep scales: are found for known creep of the array, and stay unchanged without a hold", "[dynamic]") {
  const Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 2);
  creep_taxel(data, truth, 0, 0.1, 0.7);
  creep_taxel(data, truth, 1, 0.4, 1.5);
  ArrayDynamics found = nothing_known(2);
  found.shared = truth.d;
  find_creep_scales(data, {0.1, 0.4}, {true, true}, found);
  CHECK(found.creep_scale[0] == Approx(0.7 / 1.1).epsilon(1e-6));  // over the median
  CHECK(found.creep_scale[1] == Approx(1.5 / 1.1).epsilon(1e-6));
  CHECK(found.shared.creep_share == truth.d.creep_share);
  // Without a held level they stay as they were.
  ArrayDynamics nothing = nothing_known(2);
  nothing.creep_scale = {0.3, 0.4};
  find_creep_scales(held_levels(truth.levels, 2, 5), {0.1, 0.4}, {true, true}, nothing);
  CHECK(nothing.creep_scale == std::vector<double>{0.3, 0.4});
}

TEST_CASE("creep scales: lie between 0 and 10, and leave at least a tenth of the output", "[dynamic]") {
  Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 5);
  const std::vector<double> zeros(5, 0.0), scales = {-2.0, 30.0, 2.0, 1.0, 1.0 / 3.0};
  const std::vector<bool> usable(5, true);
  for (std::size_t t = 0; t < scales.size(); ++t) creep_taxel(data, truth, t, 0.0, scales[t]);
  ArrayDynamics found = nothing_known(5);
  found.shared = truth.d;  // 0.1 of the output together: nine times that is the most
  find_creep_scales(data, zeros, usable, found);
  CHECK(found.creep_scale[0] == 0.0);
  CHECK(found.creep_scale[1] == Approx(9.0));
  for (std::size_t t = 2; t < scales.size(); ++t) CHECK(found.creep_scale[t] == Approx(scales[t]).epsilon(1e-6));
  // Of little creep ten times as much.
  truth.d.creep_share = {0.003, 0.002, 0.005};
  for (std::size_t t = 0; t < scales.size(); ++t) creep_taxel(data, truth, t, 0.0, scales[t]);
  found.shared = truth.d;
  find_creep_scales(data, zeros, usable, found);
  CHECK(found.creep_scale[1] == 10.0);
  // A taxel without output has no creep of its own.
  ArrayDynamics silent = nothing_known(1);
  silent.shared = truth.d;
  find_creep_scales(held_levels(truth.levels, 1), {0.0}, {true}, silent);
  CHECK(silent.creep_scale[0] == 1.0);
}

TEST_CASE("creep scales: an uncertain taxel's scale is pulled toward the array's", "[dynamic]") {
  const Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 3);
  for (std::size_t t = 0; t < 3; ++t) creep_taxel(data, truth, t, 0.0, t == 0 ? 1.5 : 1.0);
  const Elements all = elements_along(truth.levels, truth.d);
  const double factor = factor_of(truth);
  const std::size_t rows = 3 * (kFrames - 3);
  // The column that the scale is of: the array's change of each settled frame, times the level's volts.
  std::vector<double> column;
  double squares = 0.0;
  for (std::size_t i = 0; i < all.psi.size(); ++i) {
    double change = 0.0;
    for (std::size_t j = 0; j < 3; ++j)
      change += truth.d.creep_share[j] * (all.psi[i][j] - all.mean[i / kFrames][j]) / factor;
    column.push_back(truth.volts[i / kFrames] * change);
    if (i % kFrames >= 3) squares += column.back() * column.back();
  }
  // Errors of three frames of the first level which change neither its mean nor the scale: across 1 and the column.
  const double a = column[5], b = column[15], c = column[35];
  const double errors[] = {c - b, a - c, b - a};
  double rest = 0.0;
  std::vector<double>& volts = data.sequences[0].repeats[0].volts;
  const std::size_t places[] = {5, 15, 35};
  for (std::size_t k = 0; k < 3; ++k) {
    volts[3 * places[k]] += 10.0 * errors[k];
    rest += 100.0 * errors[k] * errors[k];
  }
  ArrayDynamics found = nothing_known(3);
  found.shared = truth.d;
  find_creep_scales(data, {0.0, 0.0, 0.0}, {true, true, true}, found);
  const double doubt2 = rest / static_cast<double>(rows) / squares / (factor * factor),
               kept = 0.0625 / (0.0625 + doubt2);
  REQUIRE((kept > 0.1 && kept < 0.99));
  CHECK(found.creep_scale[0] == Approx(1.0 + 0.5 * kept).epsilon(1e-6));
}

TEST_CASE("creep search: a hold needs ten settled frames within 0.5 psi of its first, above 0.5 psi", "[dynamic]") {
  // Frames at 2, 4, 6 s and so on: the first three of a level are within 6 s of its first.
  CHECK(holds_in(held_levels({20}, 1, 13)) == 1);
  CHECK(holds_in(held_levels({20}, 1, 12)) == 0);
  CHECK(holds_in(held_levels({20, 40, 20}, 1, 13)) == 3);
  CHECK(holds_in(held_levels({0, 20, 0}, 1, 13)) == 1);
  CHECK(holds_in(held_levels({0.5}, 1, 13)) == 0);
  CHECK(holds_in(held_levels({0.5625}, 1, 13)) == 1);
  Dataset drifting = held_levels({20}, 1, 13);
  for (const auto& [off, holds] : {std::pair{0.4375, 1}, {0.5, 0}, {-0.4375, 1}, {-0.5, 0}}) {
    drifting.sequences[0].repeats[0].steps.back().reference_psi = 20.0 + off;
    CAPTURE(off);
    CHECK(holds_in(drifting) == holds);
  }
  CHECK(holds_in({}) == 0);
}

TEST_CASE("track: lists a run's samples in order, and its span is the highest set-point", "[dynamic]") {
  const Dataset data = walked_run({}, {{0.0, 0.1, 1.0, 0.0}, {0.5, 0.1, 1.0, 0.0}},
                                  {{"a", {{{0, 10}, 1.0}, {{5}, 2.0}}}, {"b", {{{30, 20}, 1.0, 20.0, 0.25}}}}, 30.0);
  const Track track = track_of(data);
  CHECK(track.time == std::vector<double>{1, 2, 4, 25, 26});
  CHECK(track.pressure == std::vector<double>{0, 10, 5, 30.25, 20.25});
  CHECK(track.span == 30.0);
  CHECK(track.sequence == std::vector<std::size_t>{0, 0, 0, 1, 1});
  CHECK(track.repeat == std::vector<std::size_t>{0, 0, 1, 0, 0});
  CHECK(track.step == std::vector<std::size_t>{0, 1, 0, 0, 1});
  CHECK(track.volts[3][1] == Approx(0.5 + 3.025));
  CHECK(track.samples[4]->setpoint_psi == 20.0);
  // psi along it, with 20 s of conditioning before the fourth: toward 1 - half / span ln(1 + span / half) meanwhile.
  Dynamics d;
  d.creep_half = 10.0;
  const auto psi = walk_creep(track, d);
  REQUIRE(psi.size() == 5);
  const double after = 0.5 * (1.0 - std::exp(-1.0 / 3.0));  // 10 / (10 + 10)
  CHECK(psi[0][0] == 0.0);
  CHECK(psi[1][0] == Approx(after));
  const double third = 1.0 / 3.0 + (after - 1.0 / 3.0) * std::exp(-2.0 / 3.0), mean = 1.0 - std::log(4.0) / 3.0;
  CHECK(psi[2][0] == Approx(third));
  const double worked = mean + (third - mean) * std::exp(-20.0 / 3.0), target = 30.25 / 40.25;
  CHECK(psi[3][0] == Approx(target + (worked - target) * std::exp(-1.0 / 3.0)));
}

// A model's lag and creep taken back from runs and tables that its formulas made.

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
  check_alike(own, by_hand, 1e-9, 1e-9);
}

const std::vector<double> kRisesAndFalls{0, 20, 60, 30, 10};

}  // namespace

TEST_CASE("creep removal from a run: outputs of films without hysteresis are then linear in the lagged pressure",
          "[dynamic]") {
  const Dynamics d = some_dynamics();
  const std::vector<WalkedTaxel> taxels = {{0.1, 0.05, 2.0, d.lag_share}, {0.3, 0.02, 0.5, d.lag_share}};
  const Dataset run = walked_run(
      d, taxels,
      {{"a", {{kRisesAndFalls, 2.0}, {kRisesAndFalls, 1.0, 30.0}}}, {"b", {{kRisesAndFalls, 3.0, 0.0, 0.5}}}}, 60.0);
  ArrayDynamics known;
  known.shared = d;
  known.creep_scale = {2.0, 0.5};
  known.lag_share = {0.0, 0.0};
  const Dataset undone = dataset_without_dynamics(run, known, {0.1, 0.3}, 60.0);
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

TEST_CASE("creep removal from histories: those of a run continue each other, those of a table start from rest",
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
    const Histories undone = histories_without_dynamics(model, histories);
    check_close(undone.taxels[0].score[0].y, volts);
    check_close(undone.taxels[0].score[1].y, volts);
    check_close(undone.taxels[0].score[0].x, arrived_of(d, {}, 0.3, kRisesAndFalls, 2.0, run));
    check_close(undone.taxels[0].score[1].x, arrived_of(d, second, 0.3, kRisesAndFalls, 1.0, run));
    CHECK(undone.taxels[1].score[0].y == own.score[0].y);
    CHECK(undone.taxels[1].score[1].x == own.score[1].x);
    Histories timeless = histories;
    timeless.taxels[1].score[1].time_s.pop_back();
    CHECK_THROWS_AS(histories_without_dynamics(model, timeless), AnalysisError);
    // Nothing to undo: nothing is touched, nor asked for.
    SensorModel still = model;
    still.dynamics->shared.creep_share = {};
    still.dynamics->shared.lag_share = 0.0;
    CHECK(histories_without_dynamics(still, timeless).taxels[0].score[0].y == own.score[0].y);
    still.taxels[1].status = TaxelStatus::kUnfit;
    still.dynamics = model.dynamics;
    CHECK(histories_without_dynamics(still, histories).taxels[0].score[0].y == own.score[0].y);
  }
}

// The creep that one run tells, on straight films whose creep is known.

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

FitOptions three_cells() { return fit_by("preisach", {.cells = 3, .by_input = true, .linearise = true}); }

}  // namespace

TEST_CASE("creep of one run: relaxation times are spaced evenly in log time, from 3 s to the slowest", "[dynamic]") {
  const auto times = creep_times(300.0);
  CHECK(times[0] == 3.0);
  CHECK(times[1] == Approx(30.0));
  CHECK(times[2] == Approx(300.0));
  CHECK(creep_times(12.0)[1] == Approx(6.0));
}

TEST_CASE("creep of one run: slowest times up to half of the run's duration are tried", "[dynamic]") {
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

TEST_CASE("creep of one run: the misfit vanishes for the true creep, and does not depend on the output scale",
          "[dynamic]") {
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

TEST_CASE("creep of one run: the share is recovered, limited to 0.16, and zero without creep", "[dynamic]") {
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
