// Bounds within a range of inputs, where the range does not begin at 0: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/compensate/document.h"
#include "analysis/identify/elam/elam.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/linearise.h"
#include "analysis/judgement/judgement.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

constexpr double kBegin = 1000.0;  // of a range of 100

std::vector<double> moved_there(std::vector<double> x) {
  for (double& at : x) at += kBegin;
  return x;
}

Dataset single_path(const std::vector<double>& psi) {
  Repeat repeat;
  for (const double at : psi) {
    repeat.steps.push_back({at, at, 0.0, 1.0});
    repeat.volts.insert(repeat.volts.end(), {at / 20.0, at / 10.0, 9.0});
  }
  return dataset_of({{"s", {repeat}}});
}

PatternCurve line_there() {
  const std::vector<double> x{kBegin, kBegin + 100.0}, y{0.0, 10.0};
  return {x, y, 0.0, 10.0};
}

}  // namespace

TEST_CASE("range not starting at 0: sweeps are full, and repeats return to the lowest level, within 1 % of the range") {
  SensorModel fit = straight_fit();
  fit.pressure_psi = {10.0, 20.0, 60.0};
  const auto zeros = [&](double first, double last) {
    return sweep_errors(single_path({first, 20, last}), fit, 1).repeats_with_zero;
  };
  CHECK(zeros(10.49, 10.49) == 1);
  CHECK(zeros(10.51, 10) == 0);
  CHECK(zeros(10, 10.51) == 0);
  const auto sweeps = [&](double first, double last) {
    try {
      return sweep_estimates(single_path({first, 20, last}), fit, 1).sweeps;
    } catch (const AnalysisError&) {
      return 0;
    }
  };
  CHECK(sweeps(10.49, 59.51) == 1);
  CHECK(sweeps(10.51, 60) == 0);
  CHECK(sweeps(10, 59.49) == 0);
}

TEST_CASE(
    "range not starting at 0: sweeps of the external loop, and outputs at its ends, count within 1 % of the range") {
  const auto counts = [](double bottom, double top) {
    std::vector<TaxelTable> tables;
    for (const auto& [x, y] : {std::pair{std::vector<double>{0, 50, 100, 50, 0}, 0.0},
                               std::pair{std::vector<double>{bottom, 50, top, 50, bottom}, 100.0}}) {
      TaxelTable table{moved_there(x), {0, y, 0, y, 0}, branches_along(x)};
      tables.push_back(table);
    }
    return external_loop(tables, 1).ascending[1] > 1.0;
  };
  CHECK(counts(0.99, 99.01));
  CHECK_FALSE(counts(1.01, 100));
  CHECK_FALSE(counts(0, 98.99));
  TaxelHistories taxel;
  taxel.fit = {History{
      "h", moved_there({0, 0.9, 1.1, 50, 98.9, 99.1, 100}), {1, 3, 50, 60, 70, 20, 24}, {{0, 6, true}}, {}, {}}};
  const FitData ends = fit_data_of(taxel, {});
  CHECK((ends.ascending(kBegin) == 2.0 && ends.ascending(kBegin + 100.0) == 22.0));
}

TEST_CASE("range not starting at 0: turning points, folds and congruency pairs use bounds of 1 % of the range") {
  const ElamModel model{line_there(), line_there(), {}, {}};
  CHECK(turning_point(model, {true, {kBegin + 0.99, 0}, {7, 0}}).x == kBegin);
  CHECK(turning_point(model, {true, {kBegin + 1.01, 0}, {7, 0}}).x == kBegin + 1.01);
  CHECK(turning_point(model, {false, {kBegin + 99.01, 0}, {7, 0}}).x == kBegin + 100.0);
  CHECK(turning_point(model, {false, {kBegin + 98.99, 0}, {7, 0}}).x == kBegin + 98.99);
  FitData data;
  data.ascending = data.descending = line_there();
  const auto folds_from = [&](double first, double second) {
    data.histories = {History{"h", moved_there({first, 100, second, 50}), {}, {{0, 1, true}, {2, 3, false}}, {}, {}},
                      History{"i", moved_there({50, 0}), {}, {{0, 1, false}}, {}, {}}};
    return folds_of(data, 9).size();
  };
  CHECK(folds_from(0.99, 98.99) == 2);
  CHECK(folds_from(0.99, 99.01) == 0);
  CHECK(folds_from(1.01, 99.01) == 2);
  CHECK(folds_from(1.01, 98.99) == 3);
  const auto pairs_from = [&](double first, double last) {
    std::vector<double> x{first};
    for (const double turn : {30.0, 40.0, 50.0}) x.insert(x.end(), {turn, 20, first});
    x.insert(x.end(), {last, 20, 30, 40, 50, 100});
    data.histories = {History{"h", moved_there(x), x, branches_along(x), {}, {}}};
    return find_divider(data).pairs;
  };
  CHECK(pairs_from(0.99, 99.01) == 3);
  CHECK(pairs_from(1.01, 99.01) == 0);
  CHECK(pairs_from(0.99, 98.99) == 0);
}

TEST_CASE("range not starting at 0: residual levels, random paths, inner shares and mid-range starts use the range") {
  ModelTaxel taxel = by_hand::elam_taxel(line_there(), line_there());
  taxel.residual_psi = 1.0;
  const std::vector<double> half{kBegin, kBegin + 50.0, kBegin + 100.0}, y{0.0, 2.0, 10.0};
  taxel.descending = PatternCurve(half, y, 0.0, 10.0);
  const std::vector<double> psi = residual_by_level(taxel.ascending, taxel.descending, taxel.residual_psi);
  CHECK(psi[0] == Approx(1.0));
  CHECK(psi[19] == Approx(1.0));
  CHECK(psi[20] == Approx(2.5));  // a fifth of the rise over half of the range
  CHECK(psi[39] == Approx(0.625));
  const auto random_way = [](double third_top) {
    return judged_trajectory(single_path(moved_there({0, 60, 20, 60, 20, third_top, 20, 40, 20, 40, 0})),
                             single_path({0, 60}))
        .trajectory;
  };
  CHECK(random_way(59.41) == Trajectory::kOther);
  CHECK(random_way(59.39) == Trajectory::kRandomReversals);
  const auto inner = [](double from, double to) {
    Dataset data = single_path(moved_there({0, 60}));
    data.sequences.push_back(single_path(moved_there({from, to})).sequences.front());
    return judged_trajectory(data, data).inner_share;
  };
  CHECK(inner(0.6, 59.41) == 0.0);
  CHECK(inner(0.6, 59.39) == 0.5);
  const auto doubtful = [](double first) {
    std::vector<double> way{first, 0, 100, 20, 80, 30, 70, 40, 60, 50, 100, 0};
    TableSeries series{"a", 0, moved_there(way), way};
    HistoriesOptions options;
    options.turn = options.noise = 0.0;
    return !histories_of({series}, "t", options).warnings.empty();
  };
  CHECK_FALSE(doubtful(0.99));
  CHECK(doubtful(1.01));
  CHECK_FALSE(doubtful(99.01));
  CHECK(doubtful(98.99));
}
