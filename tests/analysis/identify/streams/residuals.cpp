// Streams of any model by hand, on a film of two intervals: uncertainties, rest, unknown starts, and what they leave.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>
#include <vector>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/residuals.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace tactbench::analysis;

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0. From 2 at 45: down 1.5 at 30, 1 at 15, 0 at 0.
std::shared_ptr<const PreisachModel> loop_film() {
  return std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 1, 1});
}
// 0 to 2 straight, both ways.
std::shared_ptr<const PreisachModel> straight_film() {
  return std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 0, 1});
}

ModelTaxel streamed_taxel(std::shared_ptr<const HysteresisModel> film, double full_scale) {
  ModelTaxel taxel;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::move(film);
  taxel.fit.full_scale = full_scale;
  const std::vector<double> x{0.0, 60.0}, y{0.0, full_scale};
  taxel.ascending = taxel.descending = PatternCurve(x, y, 0.0, full_scale);
  return taxel;
}

SensorModel model_of_taxels(const std::string& name, std::vector<ModelTaxel> taxels) {
  SensorModel model;
  model.model = name;
  model.taxels = std::move(taxels);
  return model;
}

History scored(const std::string& name, const std::vector<double>& outputs, double off) {
  History history;
  history.name = name;
  for (const double y : outputs) {
    history.x.push_back(30.0 * y + off);
    history.y.push_back(y);
  }
  history.branches = branches_along(history.x);
  return history;
}

}  // namespace

TEST_CASE("compensator of a film: uncertainty is the larger of both directions, flags switch at their limits") {
  const auto film = loop_film();
  CompensatorSetup setup;
  setup.noise = 0.01;
  // Four noises are 40 mV: at 45 psi going up 0.6 psi ahead, 1.2 psi back once it may have turned.
  for (const auto& [flat_psi, flat] : {std::pair{1.15, true}, {1.25, false}}) {
    setup.options.flat_share = flat_psi / 60.0;
    const auto compensator = make_compensator(*film, setup);
    compensator->step(2.0, 0.0);
    const Compensated now = compensator->step(2.0, 0.0);
    CHECK(now.pressure_psi == Approx(45.0));
    CHECK(now.uncertainty_psi == Approx(0.3));
    CHECK(now.flat == flat);
    CHECK_FALSE(now.out_of_range);
    CHECK_FALSE(now.unknown);
  }
  for (const auto& [output, out] : {std::pair{3.149, false}, {3.151, true}, {-0.149, false}, {-0.151, true}}) {
    CAPTURE(output);
    CHECK(make_compensator(*film, setup)->step(output, 0.0).out_of_range == out);
  }
}

TEST_CASE("compensator of a film: an unknown start reads midway, and half the distance adds to the uncertainty") {
  ModelTaxel taxel = streamed_taxel(loop_film(), 3.0);
  taxel.residual_psi = 2.0;  // everywhere, of a straight loop
  const SensorModel none = model_of_taxels("preisach", {});
  const auto quiet = compensator_of(none, taxel);
  quiet->start(Start::kUnknown);
  Compensated now = quiet->step(1.0, 0.0);  // 30 psi rising, 15 falling from the top
  CHECK(now.unknown);
  CHECK(now.pressure_psi == Approx(22.5));
  CHECK(now.uncertainty_psi == Approx(std::hypot(7.5, 2.0)));
  now = quiet->step(3.0, 0.0);
  CHECK_FALSE(now.unknown);
  CHECK(now.pressure_psi == Approx(60.0));
  CHECK(now.uncertainty_psi == Approx(2.0));
  CHECK(quiet->step(2.0, 0.0).pressure_psi == Approx(30.0));
  quiet->start(Start::kAtRest);
  CHECK(quiet->step(1.0, 0.0).pressure_psi == Approx(30.0));
}

TEST_CASE("compensator of a film: rests within the dead band and 1 % of the span, of adjusted outputs") {
  ModelTaxel taxel = streamed_taxel(loop_film(), 3.0);
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  const SensorModel none = model_of_taxels("preisach", {});
  const auto rests = [&](double noise, double noisier, double above) {
    taxel.noise = noise;
    return compensator_of(none, taxel, noisier)->at_rest(0.5 + 2.0 * above);
  };
  CHECK(rests(0.0, 1.0, 0.0299));
  CHECK_FALSE(rests(0.0, 1.0, 0.0301));
  // Of 20 mV on twice the model's outputs.
  CHECK(rests(0.02, 1.0, 0.0549));
  CHECK_FALSE(rests(0.02, 1.0, 0.0551));
  CHECK(rests(0.02, 2.0, 0.1099));
  CHECK_FALSE(rests(0.02, 2.0, 0.1101));
  CHECK(rests(0.0, 1.0, -1.0));
}

TEST_CASE("residual: uses the last repeat of each sequence of a run, and all sequences of a table") {
  const std::vector<double> way{0, 0.5, 1, 1.5, 2, 1.5, 1, 0.5, 0};
  Histories histories;
  TaxelHistories own;
  own.score = {scored("a", way, 9.0), scored("a", way, 0.5), scored("b", way, 1.0)};
  histories.taxels = {own, own, own};
  histories.taxels[2].score.clear();
  ModelTaxel unfit = streamed_taxel(straight_film(), 2.0);
  unfit.status = TaxelStatus::kUnfit;
  const auto residual = [&](std::int64_t run, const std::vector<std::string>& sequences) {
    histories.run = run;
    SensorModel model = model_of_taxels(
        "preisach", {streamed_taxel(straight_film(), 2.0), unfit, streamed_taxel(straight_film(), 2.0)});
    find_residuals(histories, sequences, 1, model);
    CHECK(model.taxels[1].residual_psi == 0.0);
    CHECK(model.taxels[2].residual_psi == 0.0);
    return model.taxels[0].residual_psi;
  };
  const double one = residual(4, {"b"});
  CHECK((one >= 1.0 && one < 2.0));
  CHECK(residual(4, {}) == Approx(one * std::sqrt((0.25 + 1.0) / 2.0)));
  CHECK(residual(4, {"a"}) == Approx(0.5 * one));
  // Of a table all of them.
  CHECK(residual(0, {}) == Approx(one * std::sqrt((81.0 + 0.25 + 1.0) / 3.0)));
}

TEST_CASE("residual: each inner branch is held out once, branches of the external loop never") {
  const std::vector<double> turns{0, 60, 20, 60, 30, 60, 40, 60, 0, 20, 0, 30, 0, 60, 0};
  const auto film = loop_film();
  Histories histories;
  SensorModel model = model_of_taxels("preisach", {});
  model.options.cells = 6;
  for (int t = 0; t < 40; ++t) {
    TaxelHistories& own = histories.taxels.emplace_back();
    own.taxel = t;
    History& history = own.fit.emplace_back();
    history.name = "a";
    history.x = {0.0};
    for (const double turn : turns)
      while (history.x.back() != turn) history.x.push_back(history.x.back() + (turn > history.x.back() ? 5.0 : -5.0));
    const auto state = film->state();
    for (const double x : history.x) {
      state->go(x);
      history.y.push_back(state->output_at(x));
    }
    history.branches = branches_along(history.x);
    model.taxels.push_back(streamed_taxel(film, 3.0));
    model.taxels.back().taxel = t;
  }
  const LeftOut held = leave_out(histories, {}, model, 1);
  CHECK(held.places.size() <= 32);
  CHECK(held.models.size() >= 4);
  const History& way = histories.taxels.front().fit.front();
  std::vector<int> seen(held.models.size(), 0);
  for (const Branch& branch : way.branches) {
    const double from = way.x[static_cast<std::size_t>(branch.first)];
    const bool inner = branch.ascending ? from > 0.0 : from < 60.0;
    const int part = held.part[0][static_cast<std::size_t>(branch.last)];
    CHECK((part >= 0) == inner);
    for (int i = branch.first + 1; i <= branch.last; ++i) CHECK(held.part[0][static_cast<std::size_t>(i)] == part);
    if (inner) ++seen[static_cast<std::size_t>(part)];
  }
  CHECK(std::ranges::all_of(seen, [](int branches) { return branches > 0; }));
  // A taxel with inputs of its own is not among them.
  histories.taxels[2].fit.front().branches.pop_back();
  const LeftOut others = leave_out(histories, {}, model, 1);
  CHECK(std::ranges::find(others.places, 2U) == others.places.end());
}

TEST_CASE("residual: combines the errors on held-out branches with those on fitted ones") {
  CHECK(between_branches({4.0, 1.0}) == Approx(2.0));
  CHECK(between_branches({4.0, 3.0}) == Approx(3.0));
  CHECK(residual2_of_taxel(2.0, 9.0, 3.0) == Approx(4.0));
  CHECK(residual2_of_taxel(2.0, 0.0, 0.0) == Approx(2.0));
  // 15 psi apart from 1 to 2, nothing at both ends.
  CHECK(between_external_branches(streamed_taxel(loop_film(), 3.0)) == Approx(125.0 / 12.0).epsilon(0.02));
  CHECK(between_external_branches(streamed_taxel(straight_film(), 2.0)) == Approx(0.0).margin(1e-9));
}

// Streams of a taxel whose model has lag and creep, and what it is measured by.

using tactbench::creeping::creeping_film;

TEST_CASE("dynamic streams: expect outputs as rising, and use lag and creep only for fitted taxels", "[dynamic]") {
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

TEST_CASE("dynamic streams: a taxel's readings do not depend on the ranges of other taxels", "[dynamic]") {
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
  const Histories undone = histories_without_dynamics(model, histories);
  for (std::size_t t = 0; t < 3; ++t) {
    CHECK(undone.taxels[t].score[0].y[0] == Approx(0.5));
    CHECK(undone.taxels[t].score[0].y[1] > 2.0);
    CHECK(undone.taxels[t].score[0].x[1] < 30.0);
  }
}

TEST_CASE("static streams: samples are out of range beyond the outputs by over 5 % of them or the dead band") {
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

// Which samples a residual is made of: unknown starts do not count, nor does what comes after so many.

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0. Its loop is taken as straight, so that all levels weigh the same.
SensorModel film_alone(double loop_low = 0.0) {
  SensorModel model;
  model.model = "preisach";
  ModelTaxel& taxel = model.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 1, 1});
  taxel.fit.full_scale = 3.0;
  taxel.loop_low = loop_low;
  const std::vector<double> x{0.0, 60.0}, y{0.0, 3.0};
  taxel.ascending = taxel.descending = PatternCurve(x, y, 0.0, 3.0);
  return model;
}

// Mean square of what counts, by a recording that errs by 3 psi throughout; no inner branch is there.
double counted2(const SensorModel& model, std::size_t taxel) {
  const double residual = model.taxels[taxel].residual_psi, known = between_external_branches(model.taxels[taxel]);
  Histories three;
  three.taxels.resize(1);
  three.taxels[0].score = {{"a", {57, 57}, {3, 3}, {}, {}, {}}};
  SensorModel like = model;
  like.taxels = {model.taxels[taxel]};
  find_residuals(three, {}, 1, like);
  const double factor2 = like.taxels[0].residual_psi * like.taxels[0].residual_psi / (9.0 + known);
  return residual > 0.0 ? residual * residual / factor2 - known : 0.0;
}

double counted_of(SensorModel model, const std::vector<History>& scored) {
  Histories histories;
  TaxelHistories& own = histories.taxels.emplace_back();
  own.taxel = 0;
  own.score = scored;
  find_residuals(histories, {}, 1, model);
  return counted2(model, 0);
}

}  // namespace

TEST_CASE("residual samples: if a recording starts in mid-branch, only samples with known state count") {
  // 1 V is 30 psi of a rise and 15 of a fall; from the top on 2 V are 30 psi: 6 psi off.
  const History middle{"a", {99, 60, 36}, {1, 3, 2}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {middle}) == Approx(36.0 / 2.0));
  // A hundredth of the full scale is at rest: of three samples, the first 9.4 psi off.
  const History rest{"a", {10, 60, 36}, {0.02, 3, 2}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {rest}) == Approx((9.4 * 9.4 + 36.0) / 3.0));
  // Each recording starts from the beginning; one without samples is skipped.
  const History none{"b", {}, {}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {middle, none, middle}) == Approx(36.0 / 2.0));
  CHECK(counted_of(film_alone(), {none}) == 0.0);
  CHECK(counted_of(film_alone(), {}) == 0.0);
}

TEST_CASE("residual samples: the first 20000 of a taxel count, over all its recordings") {
  History first{"a", {}, {}, {}, {}, {}};
  for (int i = 0; i < 19'999; ++i) {
    first.x.push_back(i % 2 == 0 ? 2.0 : 60.0);  // 2 psi off at the lowest output
    first.y.push_back(i % 2 == 0 ? 0.0 : 3.0);
  }
  const History second{"b", {9, 90, 90}, {0, 3, 3}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {first, second}) == Approx((10'000 * 4.0 + 81.0) / 20'000));
}

TEST_CASE("residual samples: without a stream result the residual is unknown, other taxels keep theirs") {
  SensorModel model = film_alone();
  model.taxels.push_back(model.taxels[0]);
  Histories histories;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double last : {nan, 3.0}) {
    TaxelHistories& own = histories.taxels.emplace_back();
    own.score = {{"a", {0, 57}, {0, last}, {}, {}, {}}};
  }
  find_residuals(histories, {}, 1, model);
  CHECK(counted2(model, 0) == Approx(0.0).margin(1e-9));
  CHECK(counted2(model, 1) == Approx(9.0 / 2.0));
  // More taxels than there are histories of: nothing is known of any.
  histories.taxels.pop_back();
  model.taxels[1].residual_psi = 5.0;
  find_residuals(histories, {}, 1, model);
  CHECK(model.taxels[1].residual_psi == 5.0);
}
