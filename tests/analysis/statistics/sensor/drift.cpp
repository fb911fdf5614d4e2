// The error of a stored model on data, against answers worked out on paper. Drift: two taxels of output = input, later
// data of four points at inputs 0, 0, 4, 4.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "analysis/identify/histories.h"
#include "analysis/models/monotone.h"
#include "analysis/statistics/scoring/score.h"
#include "analysis/statistics/sensor/drift.h"

using namespace tactbench::analysis;

namespace {

ModelTaxel unit_line(int number) {
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  const std::vector<double> ends{0.0, 10.0};
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, ends, 0.0, 10.0));
  taxel.fit.full_scale = 10.0;
  taxel.fit.mean_error = 0.15;
  taxel.ascending = taxel.descending = PatternCurve(ends, ends, 0.0, 10.0);
  return taxel;
}

SensorModel two_taxels() {
  SensorModel document;
  document.model = "monotone";
  document.input_unit = "psi";
  document.output_unit = "V";
  document.columns = 2;
  for (const int number : {0, 1, kMeanTaxel}) document.taxels.push_back(unit_line(number));
  return document;
}

TaxelHistories later(int number, std::vector<double> x, std::vector<double> y) {
  TaxelHistories taxel;
  taxel.taxel = number;
  History history;
  history.branches = branches_along(x);
  history.x = std::move(x);
  history.y = std::move(y);
  taxel.score = {std::move(history)};
  return taxel;
}

// The first taxel has a zero of 1 and a gain of 2, with residuals of +0.1 and -0.1 at either end; the second a zero of
// 0.5 and nothing else.
Histories later_data() {
  Histories histories;
  histories.columns = 2;
  histories.content_sha256 = "0123456789abcdef";
  histories.taxels.push_back(later(0, {0, 0, 4, 4}, {1.1, 0.9, 9.1, 8.9}));
  histories.taxels.push_back(later(1, {0, 0, 4, 4}, {0.5, 0.5, 4.5, 4.5}));
  return histories;
}

}  // namespace

TEST_CASE("drift: zero, gain, their uncertainties and the error after each adjustment match hand-computed values") {
  const Drift drift = drift_of(two_taxels(), later_data(), 0.02);
  REQUIRE(drift.taxels.size() == 2);
  const TaxelDrift& first = drift.taxels[0];
  CHECK(first.zero == Approx(1.0));
  CHECK(first.gain == Approx(2.0));
  CHECK(first.zero_alone == Approx(3.0));  // the means are 5 and 2
  // Residual variance 4 x 0.01 / 2 = 0.02; inputs have squares of 16 about their mean of 2.
  CHECK(first.gain_u == Approx(std::sqrt(0.02 / 16.0)));
  CHECK(first.zero_u == Approx(0.1));  // 0.02 / 4 and (2 gain_u)^2 = 0.005 each
  CHECK(first.as_is == Approx(0.3));   // 1.1, 0.9, 5.1, 4.9 of a full scale of 10
  CHECK(first.zeroed == Approx(0.2));  // 1.9, 2.1, 2.1, 1.9
  CHECK(first.adjusted == Approx(0.01));
  const TaxelDrift& second = drift.taxels[1];
  CHECK(second.zero_alone == Approx(0.5));
  CHECK(second.zero_u == Approx(0.0).margin(1e-12));
  CHECK(second.as_is == Approx(0.05));
  CHECK(second.zeroed == Approx(0.0).margin(1e-12));
  CHECK(drift.as_is == Approx(0.175));
  CHECK(drift.zeroed == Approx(0.1));
  CHECK(drift.adjusted == Approx(0.005));
  // Of the array: zeros of 0.1 and 0.05 of full scale, gains of 2 and 1.
  CHECK(drift.zero == Approx(0.075));
  CHECK(drift.zero_u == Approx(2.0 * std::hypot(0.5 * 0.01, 0.025, 0.005 / std::sqrt(3.0))));
  CHECK(drift.gain == Approx(0.5));
  CHECK(drift.gain_u == Approx(2.0 * std::hypot(0.5 * std::sqrt(0.02 / 16.0), 0.5, 0.005 / std::sqrt(3.0))));
}

TEST_CASE("drift: the verdict follows from the error left within the tolerance, by default twice the fit's error") {
  const Histories data = later_data();  // 17.5 % as it is, 10 % with zero, 0.5 % with zero and gain
  CHECK(drift_of(two_taxels(), data, 0.18).verdict == DriftVerdict::kGood);
  CHECK(drift_of(two_taxels(), data, 0.17).verdict == DriftVerdict::kZero);
  CHECK(drift_of(two_taxels(), data, 0.09).verdict == DriftVerdict::kGain);
  CHECK(drift_of(two_taxels(), data, 0.004).verdict == DriftVerdict::kRecalibrate);
  CHECK(drift_of(two_taxels(), data).tolerance == Approx(0.03));  // 0.15 of 10, twice
  SensorModel exact = two_taxels();
  for (ModelTaxel& taxel : exact.taxels) taxel.fit.mean_error = 0.0;
  CHECK(drift_of(exact, data).tolerance == Approx(0.005));
}

TEST_CASE("drift: the verdict names the part that moved, even where a zero shift resembles a gain change") {
  struct Row {
    double zero, gain;
    DriftVerdict verdict;
  };
  constexpr double kOutputNoise = 0.01;
  // Inputs of 2 and 4: a gain of 0.9 is off by 0.2 and 0.4, and by 0.1 once a zero of -0.3 is taken off.
  for (const Row& row : {Row{0.3, 1.0, DriftVerdict::kZero}, Row{0.0, 0.9, DriftVerdict::kGain},
                         Row{0.6, 0.9, DriftVerdict::kGain}, Row{-1.0, 0.95, DriftVerdict::kZero}}) {
    Histories data;
    data.columns = 2;
    for (const int taxel : {0, 1}) {
      const double low = row.zero + 2 * row.gain, high = row.zero + 4 * row.gain;
      data.taxels.push_back(later(taxel, {2, 2, 4, 4},
                                  {low + kOutputNoise, low - kOutputNoise, high + kOutputNoise, high - kOutputNoise}));
    }
    const Drift drift = drift_of(two_taxels(), data, 0.015);
    INFO(row.zero << " " << row.gain);
    CHECK(drift.zeroed <= 0.015);
    CHECK(drift.verdict == row.verdict);
    CHECK(drift.zero_moved() == (row.zero != 0.0));
    CHECK(drift.gain_moved() == (row.gain != 1.0));
  }
}

TEST_CASE("drift: a gain is fitted only if the inputs cover a tenth of the model's range") {
  Histories narrow;
  narrow.taxels.push_back(later(0, {0, 0, 0.9, 0.9}, {1.0, 1.0, 2.8, 2.8}));
  const TaxelDrift drift = drift_of(two_taxels(), narrow).taxels.front();
  CHECK(drift.gain == 1.0);
  CHECK(drift.gain_u == 0.0);
  CHECK(drift.zero == Approx(1.45));  // of means 1.9 and 0.45
  // Residuals -0.45 and +0.45: variance 4 x 0.2025 / 2, of the mean of four.
  CHECK(drift.zero_u == Approx(std::sqrt(0.405 / 4.0)));
  // Two samples leave no degree of freedom, and one counts: residuals of -0.5 and 0.5; 0.5 over one, of two.
  Histories two;
  two.taxels.push_back(later(0, {3, 3.5}, {7, 8.5}));
  const TaxelDrift of_two = drift_of(two_taxels(), two).taxels.front();
  CHECK(of_two.gain == 1.0);
  CHECK(of_two.zero == Approx(4.5));
  CHECK(of_two.zero_u == Approx(std::sqrt(0.5 / 2)));
  CHECK(of_two.as_is == Approx((4.0 + 5.0) / 2 / 10));
  CHECK(of_two.zeroed == Approx(0.05));
}

TEST_CASE("drift adjustment: uses each taxel's own zero and gain, and their means for the mean taxel") {
  const Histories data = later_data();
  const Drift drift = drift_of(two_taxels(), data);
  const SensorModel both = adjusted(two_taxels(), drift, data, true);
  CHECK(both.taxel(0).zero == Approx(1.0));
  CHECK(both.taxel(0).gain == Approx(2.0));
  CHECK(both.taxel(1).zero == Approx(0.5));
  CHECK(both.taxel(kMeanTaxel).zero == Approx(0.75));
  CHECK(both.taxel(kMeanTaxel).gain == Approx(1.5));
  const SensorModel zero = adjusted(two_taxels(), drift, data, false);
  CHECK(zero.taxel(0).zero == Approx(3.0));
  CHECK(zero.taxel(0).gain == 1.0);
  CHECK(zero.taxel(kMeanTaxel).zero == Approx(1.75));
  CHECK(zero.taxel(kMeanTaxel).gain == 1.0);
  CHECK(drift_of(both, data).as_is == Approx(0.005));
  // Its loop moves with it; adjusted once more from there, by the same data, it is the model as it was fitted, moved.
  CHECK(both.taxel(0).y0() == Approx(1.0));
  CHECK(both.taxel(0).yu() == Approx(21.0));
  CHECK(zero.taxel(0).y0() == Approx(3.0));
  CHECK(zero.taxel(0).yu() == Approx(13.0));
  const SensorModel again = adjusted(zero, drift_of(zero, data), data, true);
  CHECK(again.taxel(0).y0() == Approx(1.0));
  CHECK(again.taxel(0).yu() == Approx(21.0));
  CHECK(both.parent_sha256 == sha256_of(two_taxels()));
  for (const SensorModel* made : {&both, &zero}) CHECK_THAT(made->adjustment, Catch::Contains("0123456789ab"));
}
