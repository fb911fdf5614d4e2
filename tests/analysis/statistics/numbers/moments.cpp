// Means, deviations, quantiles and lines against answers by hand; where two ways of adding up round otherwise, both.
// Noise of differences, and scores by hold and rate.

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/monotone.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace tactbench::analysis;

namespace {

using Doubles = std::vector<double>;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("moments: means of all and of selected values match hand-computed values, without values they are NaN") {
  CHECK(mean_of(Doubles{1.0, 2.0, 6.0}) == 3.0);
  CHECK(mean_of(Doubles{0.1, 0.2, 0.3}) == 0.20000000000000004);
  CHECK(std::isnan(mean_of(Doubles{})));
  const Doubles frame{1.0, 10.0, 100.0, 1000.0};
  const std::vector<int> chosen{3, 1};
  const std::vector<std::size_t> none;
  CHECK(mean_of_chosen(std::span<const double>(frame), std::span<const int>(chosen)) == 505.0);
  CHECK(std::isnan(mean_of_chosen(std::span<const double>(frame), std::span<const std::size_t>(none))));
  CHECK(finite_of(Doubles{kNan, 2.0, kInfinite, 1.0, -kInfinite}) == Doubles{2.0, 1.0});
}

TEST_CASE("moments: deviations about the mean and about a given value match hand-computed values") {
  const Doubles values{2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0};  // mean 5, squares 32
  CHECK(sum_of_squares_about(values, 5.0) == 32.0);
  CHECK(sum_of_squares_about(values, 1.0) == 32.0 + 8.0 * 16.0);
  CHECK(sample_variance(values) == 32.0 / 7.0);
  CHECK(sample_deviation(values) == std::sqrt(32.0 / 7.0));
  CHECK(sample_deviation(Doubles{3.0, 3.0}) == 0.0);
  CHECK(std::isnan(sample_deviation(Doubles{3.0})));
  CHECK(std::isnan(sample_variance(Doubles{})));
}

TEST_CASE("moments: medians and quantiles are one of the values, or lie between two") {
  CHECK(median_of({9.0, 1.0, 5.0}) == 5.0);
  CHECK(median_of({9.0, 1.0, 5.0, 2.0}) == 3.5);
  CHECK(median_of({kNan, 4.0, kInfinite}) == 4.0);
  CHECK(std::isnan(median_of({kNan})));
  const Doubles ten{9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0};
  for (const auto& [share, value] : {std::pair(0.0, 0.0), {0.25, 2.0}, {0.5, 5.0}, {0.9, 9.0}, {1.0, 9.0}})
    CHECK(quantile_of(ten, share) == value);
  CHECK(quantile_of({7.0}, 0.5) == 7.0);
  const Doubles sorted{0.0, 10.0, 20.0, 40.0};
  for (const auto& [share, value] : {std::pair(0.0, 0.0), {0.5, 15.0}, {0.75, 25.0}, {1.0, 40.0}})
    CHECK(quantile_between(sorted, share) == value);
  CHECK(quantile_between(Doubles{7.0}, 0.9) == 7.0);
}

TEST_CASE("moments: a value lies between two rising ones, on one of them, or at the end beyond which it is") {
  struct Row {
    double at;
    std::size_t low, high;
    double share;
  };
  const Row rows[] = {{0.5, 0, 0, 0},  {1, 0, 0, 0}, {1.5, 0, 1, 0.5}, {2, 1, 1, 0},
                      {5, 1, 2, 0.75}, {6, 2, 2, 0}, {7, 2, 2, 0},     {kNan, 0, 0, 0}};
  for (const Row& row : rows) {
    CAPTURE(row.at);
    const Between place = place_among(Doubles{1.0, 2.0, 6.0}, row.at);
    CHECK(place.low == row.low);
    CHECK(place.high == row.high);
    CHECK(place.share == row.share);
  }
}

TEST_CASE("moments: scatter within and between groups of unequal size matches hand-computed values") {
  // Means 2, 5 and 9 of 2, 3 and 1 values, 28/6 of all: within 2 + 2 of 3 degrees of freedom.
  const std::vector<Doubles> groups{{1.0, 3.0}, {}, {4.0, 5.0, 6.0}, {9.0}};
  const GroupedScatter scatter = grouped_scatter(groups);
  CHECK(scatter.groups == 3.0);
  CHECK(scatter.readings == 6.0);
  CHECK(scatter.within_dof == 3.0);
  CHECK(scatter.within == Approx(4.0 / 3));
  const double all = 28.0 / 6, squares = 2 * std::pow(2 - all, 2) + 3 * std::pow(5 - all, 2) + std::pow(9 - all, 2);
  CHECK(scatter.between == Approx((squares / 2 - 4.0 / 3) / ((6 - 14.0 / 6) / 2)));
  CHECK(grouped_scatter(std::vector<Doubles>{{1.0, 2.0}}).between == 0.0);
  CHECK(grouped_scatter(std::vector<Doubles>{{1.0}, {1.0}}).within == 0.0);
}

TEST_CASE("moments: least-squares line, its residual and the correlation match hand-computed values") {
  const Doubles x{0.0, 1.0, 2.0, 3.0, 4.0}, y{1.0, 3.0, 5.0, 7.0, 9.0};
  const LineFit line = line_fit(x, y);
  CHECK(line.slope() == Approx(2.0));
  CHECK(line.at_zero() == Approx(1.0));
  CHECK(line.correlation() == Approx(1.0));
  CHECK(residual_sum_of_squares(line, x, y) == Approx(0.0).margin(1e-20));
  // (0, 0), (1, 3), (2, 0): mean 1, level; it leaves 1 + 4 + 1.
  const LineFit level = line_fit(Doubles{0.0, 1.0, 2.0}, Doubles{0.0, 3.0, 0.0});
  CHECK(level.slope() == 0.0);
  CHECK(level.at_zero() == 1.0);
  CHECK(level.correlation() == 0.0);
  CHECK(residual_sum_of_squares(level, Doubles{0.0, 1.0, 2.0}, Doubles{0.0, 3.0, 0.0}) == 6.0);
  CHECK(line_fit(x, Doubles{9.0, 7.0, 5.0, 3.0, 1.0}).correlation() == Approx(-1.0));
  const LineFit upright = line_fit(Doubles{2.0, 2.0}, Doubles{0.0, 1.0});
  CHECK(upright.correlation() == 0.0);
  CHECK(std::isnan(upright.slope()));
}

TEST_CASE("pooled scatter: s, degrees of freedom and parts match hand-computed values, non-finite parts are left out") {
  using Rows = std::vector<std::vector<double>>;
  struct Row {
    const char* what;
    Rows rows;
    double s, dof;
    std::size_t parts;
  };
  const std::vector<Row> cases = {
      {"fully correlated: n - 1", {{1, 11, 21}, {3, 13, 23}}, std::sqrt(2.0), 1.0, 3},
      {"parts cancel in the mean: (n - 1)(parts - 1)", {{1, 2, 5, 8}, {3, 0, 7, 6}}, std::sqrt(2.0), 3.0, 4},
      // Variances 1 and 7, mean 4; of the means 1.5, 1.5 and 4.5 it is 3, so that 1 is own.
      {"common and own", {{1, 2}, {2, 1}, {3, 6}}, 2.0, 2.0 * 16.0 / (9.0 + 1.0), 2},
      // Variances 1 and 0, mean 1/2, half of it common.
      {"a part that is not finite", {{1, kNan, 2}, {2, 9, 2}, {3, 9, 2}}, std::sqrt(0.5), 4.0, 2}};
  for (const Row& row : cases) {
    INFO(row.what);
    const PooledScatter scatter = pooled_scatter(row.rows);
    REQUIRE(scatter.known());
    CHECK(scatter.s == Approx(row.s));
    CHECK(scatter.dof == Approx(row.dof));
    CHECK((scatter.parts == row.parts && scatter.rows == row.rows.size()));
  }
  for (const Rows& none : {Rows{{1, 2}}, Rows{{kNan}, {kNan}}, Rows{}}) CHECK_FALSE(pooled_scatter(none).known());
  const PooledScatter still = pooled_scatter(Rows{{1, 2}, {1, 2}});
  CHECK((still.s == 0.0 && still.dof == 1.0));
  CHECK(pooled_scatter(Rows{{1}, {2}, {3}}).dof == 2.0);
}

// The noise of differences, few samples by hand: which order counts, of how many differences.

namespace {

using Samples = std::vector<double>;

// A difference of unit norm is as large as the noise; the median of a normal one is 0.67449 of it.
double as_noise(double difference) { return difference / 0.67449; }

double noise_of(const Samples& y) { return difference_noise(std::vector<Stretch>{{{}, y}}); }
double placed_noise(const Samples& x, const Samples& y) { return difference_noise(std::vector<Stretch>{{x, y}}); }

Samples ramp(std::size_t count) {
  Samples y;
  for (std::size_t i = 0; i < count; ++i) y.push_back(static_cast<double>(i));
  return y;
}

}  // namespace

TEST_CASE("difference noise: of two to five samples matches hand-computed values, and is 0 for fewer") {
  CHECK(noise_of({5.0, 6.0}) == Approx(as_noise(1.0 / std::sqrt(2.0))));
  CHECK(noise_of({0.0, 1.0, 2.0}) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // the second order is one difference
  // First differences 4, -1, 6, -6; second -5, 7, -12: of sqrt 6 the middle one 7; first of sqrt 2 the upper middle 6.
  // Third 12, -19 over sqrt 20: the larger, 4.25.
  CHECK(noise_of({0.0, 4.0, 3.0, 9.0, 3.0}) == Approx(as_noise(7.0 / std::sqrt(6.0))));
  CHECK(noise_of({}) == 0.0);
  CHECK(noise_of({3.0}) == 0.0);
}

TEST_CASE("difference noise: an order counts from twenty differences on, or from two if no order has twenty") {
  CHECK(noise_of(ramp(4)) == Approx(0.0).margin(1e-12));  // two of the second order
  CHECK(noise_of(ramp(20)) == Approx(0.0).margin(1e-12));
  CHECK(noise_of(ramp(21)) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // twenty of the first, nineteen of the second
  CHECK(noise_of(ramp(22)) == Approx(0.0).margin(1e-12));
}

TEST_CASE("difference noise: the smallest of the orders up to the sixth counts") {
  // 1 -1 1 -1 ...: the difference of order k is the sum of its weights' sizes, 2^k over the root of the sum of squares,
  // C(2k, k): 1.41, 1.63, 1.79, 1.91, 2.02, 2.11. The first is least.
  Samples y;
  for (int i = 0; i < 40; ++i) y.push_back(i % 2 == 0 ? 1.0 : -1.0);
  CHECK(noise_of(y) == Approx(as_noise(2.0 / std::sqrt(2.0))));
  // A parabola, and a curve of the fifth degree, which the sixth order alone takes away.
  Samples fifth, sixth;
  for (int i = 0; i < 40; ++i) {
    fifth.push_back(std::pow(i - 20.0, 5));
    sixth.push_back(std::pow(i - 20.0, 6));
  }
  CHECK(noise_of(fifth) == Approx(0.0).margin(1e-3));
  CHECK(noise_of(sixth) == Approx(as_noise(720.0 / std::sqrt(924.0))));  // 6! of C(12, 6)
}

TEST_CASE("difference noise: differences are divided by inputs if that is smaller, equal inputs are skipped") {
  CHECK(placed_noise({0, 1, 3, 7}, {0, 1, 3, 7}) == Approx(0.0).margin(1e-12));
  CHECK(noise_of({0, 1, 3, 7}) == Approx(as_noise(2.0 / std::sqrt(6.0))));  // 1 and 2; the third order is one, 1
  CHECK(placed_noise({0, 0, 1, 3, 7}, {5, 0, 1, 3, 7}) == Approx(0.0).margin(1e-12));
  CHECK(placed_noise({2, 2}, {0, 1}) == Approx(as_noise(1.0 / std::sqrt(2.0))));  // as if evenly placed
  // Several stretches together; one without inputs, and none is divided: of the third order there are two now, of 1.
  const Samples x{0, 1, 3, 7}, y{0, 1, 3, 7};
  CHECK(difference_noise(std::vector<Stretch>{{x, y}, {{}, y}}) == Approx(as_noise(1.0 / std::sqrt(20.0))));
  CHECK(difference_noise(std::vector<Stretch>{{{}, Samples{0.0, 1.0}}, {{}, Samples{0.0, 3.0}}, {{}, Samples{0, 2}}}) ==
        Approx(as_noise(2.0 / std::sqrt(2.0))));
}

TEST_CASE("coverage: degrees of freedom ignore zero shares, and the factor is that of whole degrees") {
  // u 1 and 2 with 3 and 12 degrees: 25 / (1 / 3 + 16 / 12).
  CHECK(effective_dof(std::vector<VarianceShare>{{1.0, 3.0}, {2.0, 12.0}}) == Approx(15.0));
  CHECK(effective_dof(std::vector<VarianceShare>{{1.0, 3.0}, {0.0, 1.0}, {2.0}}) == Approx(75.0));
  CHECK(std::isinf(effective_dof(std::vector<VarianceShare>{{0.0, 3.0}})));
  CHECK(combined_uncertainty(std::vector<VarianceShare>{{3.0}, {4.0}, {12.0}}) == Approx(13.0));
  CHECK(coverage_factor(2.9999999999) == coverage_factor(3.0));  // three, but for rounding
  CHECK(coverage_factor(2.99) == coverage_factor(2.0));
  CHECK_THROWS_AS(coverage_factor(0.99), std::invalid_argument);
  CHECK_THROWS_AS(coverage_factor(3.0, 0.0), std::invalid_argument);
}

// Errors gathered by hold and by rate, and what keeps a model from being scored: by hand.

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
  return id_of_refusal([&] {
    check_same_source(document, histories);
    return true;
  });
}

}  // namespace

TEST_CASE("score bins: start at 1, 2 and 5 of each decade, the lower bound included within 1e-6") {
  const std::pair<double, double> bins[] = {{0.1, 0.1},
                                            {0.15, 0.1},
                                            {0.1999, 0.1},
                                            {0.2, 0.2},
                                            {0.4999, 0.2},
                                            {0.5, 0.5},
                                            {0.9999, 0.5},
                                            {1.0, 1.0},
                                            {1.9999999, 2.0},
                                            {1.99999, 1.0},
                                            {4.9999999, 5.0},
                                            {4.9999, 2.0},
                                            {9.99, 5.0},
                                            {10.0, 10.0},
                                            {2000.0, 2000.0},
                                            {0.003, 0.002},
                                            {2.0 * (1.0 - 0.95e-6), 2.0},
                                            {2.0 * (1.0 - 1.05e-6), 1.0}};
  for (const auto& [hold_s, low] : bins) {
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
  const ScoreOptions options{.x_high = 10.0, .y_high = 10.0};
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
