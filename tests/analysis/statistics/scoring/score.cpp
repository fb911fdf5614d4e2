// Errors gathered by hold and by rate, and what keeps a model from being scored: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/monotone.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/creeping_film.h"

using namespace tactbench::analysis;

namespace {

double lower_bound_of(double hold_s) {
  Score score;
  score.add_sample(1.0, hold_s, 0.0);
  return score.by_hold.empty() ? -1.0 : score.by_hold.front().low;
}

SensorModel line_of(const std::string& source, int taxels = 1) {
  SensorModel document;
  document.source = source;
  document.origin = "simulated";
  document.sensor_serial = "S";
  document.scanner_serial = "C";
  document.input_unit = "psi";
  document.output_unit = "V";
  const std::vector<double> ends{0.0, 10.0};
  for (int i = 0; i < taxels; ++i) {
    ModelTaxel taxel;
    taxel.taxel = i + 1 == taxels && taxels > 1 ? -1 : i;
    taxel.status = TaxelStatus::kFitted;
    taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, ends, 0.0, 10.0));
    taxel.fit.full_scale = 10.0 + i;
    document.taxels.push_back(std::move(taxel));
  }
  return document;
}

Histories measured_as(const SensorModel& document) {
  Histories histories;
  histories.source = "run 5";
  histories.origin = document.origin;
  histories.sensor_serial = document.sensor_serial;
  histories.scanner_serial = document.scanner_serial;
  histories.input_unit = document.input_unit;
  histories.output_unit = document.output_unit;
  return histories;
}

std::string refused(const SensorModel& document, const Histories& histories) {
  try {
    check_same_source(document, histories);
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("score bins: start at 1, 2 and 5 of each decade, the lower bound included within 1e-6") {
  for (const auto& [hold_s, low] :
       {std::pair{0.1, 0.1}, std::pair{0.15, 0.1}, std::pair{0.1999, 0.1}, std::pair{0.2, 0.2}, std::pair{0.4999, 0.2},
        std::pair{0.5, 0.5}, std::pair{0.9999, 0.5}, std::pair{1.0, 1.0}, std::pair{1.9999999, 2.0},
        std::pair{1.99999, 1.0}, std::pair{4.9999999, 5.0}, std::pair{4.9999, 2.0}, std::pair{9.99, 5.0},
        std::pair{10.0, 10.0}, std::pair{2000.0, 2000.0}, std::pair{0.003, 0.002},
        std::pair{2.0 * (1.0 - 0.95e-6), 2.0}, std::pair{2.0 * (1.0 - 1.05e-6), 1.0}}) {
    INFO(hold_s);
    CHECK(lower_bound_of(hold_s) == Approx(low));
  }
  CHECK(lower_bound_of(0.0) == -1.0);
  CHECK(lower_bound_of(-1.0) == -1.0);
}

TEST_CASE("score bins: come in order with sum, maximum and count, and two scores add up") {
  Score score;
  score.add_sample(3.0, 7.0, 0.0);
  score.add_sample(1.0, 0.3, 20.0);
  score.add_sample(2.0, 1.5, 30.0);
  score.add_sample(5.0, 8.0, 0.4);
  CHECK(score.compensated.samples == 4);
  CHECK(score.compensated.sum == 11.0);
  CHECK(score.compensated.max == 5.0);
  REQUIRE(score.by_hold.size() == 3);
  CHECK((score.by_hold[0].low == Approx(0.2) && score.by_hold[0].high == Approx(0.5)));
  CHECK((score.by_hold[1].low == Approx(1.0) && score.by_hold[1].high == Approx(2.0)));
  CHECK((score.by_hold[2].low == Approx(5.0) && score.by_hold[2].high == Approx(10.0)));
  CHECK((score.by_hold[2].error.samples == 2 && score.by_hold[2].error.mean() == 4.0));
  REQUIRE(score.by_rate.size() == 2);
  CHECK((score.by_rate[1].low == Approx(20.0) && score.by_rate[1].error.sum == 3.0));
  Score both;
  both.add_sample(9.0, 6.0, 0.0);
  both.direct.add(0.5);
  both.raw.add(0.25);
  both.free_running.add(0.75);
  both.add(score);
  CHECK((both.compensated.samples == 5 && both.compensated.sum == 20.0 && both.compensated.max == 9.0));
  CHECK((both.by_hold.size() == 3 && both.by_hold[2].error.samples == 3 && both.by_hold[2].error.max == 9.0));
  CHECK((both.direct.samples == 1 && both.raw.sum == 0.25 && both.free_running.max == 0.75));
  CHECK(ErrorSum().mean() == 0.0);
}

TEST_CASE("score: samples without elapsed time have no rate, histories without times have no bins") {
  const SensorModel line = line_of("model");
  const HysteresisModel& model = *line.taxels[0].fit.model;
  ScoreOptions options;
  options.x_high = options.y_high = 10.0;
  History history{"h", {0, 4, 8}, {0, 5, 8.5}, {{0, 2, true}}, {0, 2, 2}, {0, 1, 0}};
  const Score timed = score(model, std::vector<History>{history}, options);
  CHECK((timed.direct.samples == 2 && timed.direct.sum == Approx(1.5) && timed.direct.max == Approx(1.0)));
  CHECK(timed.free_running.sum == Approx(1.5));
  CHECK(timed.compensated.sum == Approx(1.5));
  CHECK(timed.raw.sum == Approx(1.5));
  REQUIRE((timed.by_hold.size() == 1 && timed.by_rate.size() == 1));
  CHECK((timed.by_hold[0].error.samples == 1 && timed.by_hold[0].error.sum == Approx(1.0)));
  CHECK((timed.by_rate[0].low == Approx(2.0) && timed.by_rate[0].error.sum == Approx(1.0)));  // 4 in 2 s
  history.time_s.clear();
  history.held_s.clear();
  const Score untimed = score(model, std::vector<History>{history}, options);
  CHECK((untimed.by_hold.empty() && untimed.by_rate.empty() && untimed.direct.samples == 2));
}

TEST_CASE("score: data of another origin, sensor, scanner, unit or sign are refused") {
  const SensorModel document = line_of("model");
  const auto id_with = [&](auto change) {
    Histories other = measured_as(document);
    change(other);
    return refused(document, other);
  };
  CHECK(id_with([](Histories&) {}).empty());
  CHECK(id_with([](Histories& other) { other.origin = "hardware"; }) == "TB-ANALYSIS-ORIGIN");
  CHECK(id_with([](Histories& other) { other.sensor_serial = "T"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_with([](Histories& other) { other.scanner_serial.clear(); }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_with([](Histories& other) { other.input_unit = "kPa"; }) == "TB-MODEL-UNITS");
  CHECK(id_with([](Histories& other) { other.output_unit = "mV"; }) == "TB-MODEL-UNITS");
  CHECK(id_with([](Histories& other) { other.input_unit = other.output_unit = ""; }) == "TB-MODEL-UNITS");
  CHECK(id_with([](Histories& other) { other.falling = true; }) == "TB-ANALYSIS-FALLING");
}

TEST_CASE("score: the array's taxels are summed, and the mean taxel is scored separately") {
  const SensorModel document = line_of("model", 3);  // taxels 0 and 1, and their mean
  Histories histories = measured_as(document);
  for (const auto& [taxel, off] : {std::pair{0, 1.0}, std::pair{1, 2.0}, std::pair{-1, 0.5}}) {
    TaxelHistories own;
    own.taxel = taxel;
    own.score = own.fit = {History{"h", {0, 4, 8}, {0, 4 + off, 8 - off}, {{0, 2, true}}, {}, {}}};
    histories.taxels.push_back(own);
  }
  const ModelScore found = score_model(document, histories, {}, 1);
  CHECK(found.count == 2);
  CHECK((found.taxels.direct.samples == 4 && found.taxels.direct.sum == Approx(6.0)));
  CHECK((found.mean.direct.samples == 2 && found.mean.direct.sum == Approx(1.0)));
  CHECK(found.full_scale == 12.0);
  // Of one taxel alone that is the mean, too.
  const SensorModel single = line_of("model");
  const ModelScore alone = score_model(single, histories, {}, 1);
  CHECK((alone.count == 1 && alone.full_scale == 10.0 && alone.mean.direct.sum == Approx(2.0)));
  CHECK(alone.taxels.direct.sum == Approx(2.0));
  histories.taxels.clear();
  CHECK_THROWS_AS(score_model(single, histories, {}, 1), AnalysisError);
}

// The score of a dynamic model: in runs time goes on from sequence to sequence, and what passed beside a hold was work;
// each sequence of a table is a recording of its own.

namespace {

// Held 2 s at 20 psi after 100 s, 3 s at 30; then, 7 s later and for 7 s, at 15 psi, and for 4 s at 40.
Histories two_ways_up(std::int64_t run) {
  Histories histories;
  histories.run = run;
  histories.source = "data";
  TaxelHistories& taxel = histories.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.fit = taxel.score = {
      {"first", {10, 20, 30}, {0.5, 1.0, 1.6}, {{0, 2, true}}, {0, 100, 103}, {0, 2, 3}},
      {"second", {15, 40}, {0.8, 2.5}, {{0, 1, true}}, {110, 114}, {7, 4}},
  };
  return histories;
}

}  // namespace

TEST_CASE("dynamic score: a run's time continues over sequences, sequences of a table are separate", "[dynamic]") {
  SensorModel document = tactbench::creeping::creeping_film();
  document.input_unit = "psi";
  document.output_unit = "V";
  const auto scored = [&](std::int64_t run) {
    return score_model(document, two_ways_up(run), {}, 1).taxels.compensated;
  };
  const auto off = [](const Compensated& there, double psi) { return std::abs(there.pressure_psi - psi); };

  const auto run = compensator_of(document, document.taxels[0]);
  (void)run->step(0.5, 0.0);
  run->work(98.0);  // of 100 s the first level was held for 2
  double sum = off(run->step(1.0, 2.0), 20.0);
  sum += off(run->step(1.6, 3.0), 30.0);
  (void)run->step(0.8, 7.0);
  sum += off(run->step(2.5, 4.0), 40.0);
  CHECK(scored(5).samples == 3);
  CHECK(scored(5).sum == Approx(sum).epsilon(1e-12));

  const auto table = compensator_of(document, document.taxels[0]);
  (void)table->step(0.5, 0.0);
  double table_sum = off(table->step(1.0, 100.0), 20.0);
  table_sum += off(table->step(1.6, 3.0), 30.0);
  table->start(Start::kUnknown);  // 0.8 V is not the unloaded output
  (void)table->step(0.8, 0.0);
  table_sum += off(table->step(2.5, 4.0), 40.0);
  CHECK(scored(0).samples == 3);
  CHECK(scored(0).sum == Approx(table_sum).epsilon(1e-12));
  CHECK(std::abs(table_sum - sum) > 0.01);
}
