// What is made of a table's samples before any model: noise, turns and external loop.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench::analysis;
using tactbench::tests::play_samples;

namespace {

struct AddedNoise {
  double input = 0.0, output = 0.0;
};

// A sensor with play along the turning points.
TableSeries play_series(const std::string& sequence, const std::vector<double>& turns, int steps = 40,
                        AddedNoise noise = {}) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  TableSeries series{sequence, 0, {}, {}};
  for (const auto& sample : play_samples(turns, steps)) {
    series.input.push_back(sample.input + noise.input * normal(random));
    series.output.push_back(sample.output + noise.output * normal(random));
  }
  return series;
}

std::size_t branches_of(const TableSeries& series, double turn = -1.0) {
  HistoriesOptions options;
  options.turn = turn;
  return histories_of({series}, "t.csv", options).taxels[0].fit[0].branches.size();
}

const std::vector<double> kTurningPoints = {0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0};

}  // namespace

TEST_CASE("noise is estimated from the fitted branches, without turns and without scored data") {
  const std::vector<TableSeries> table = {play_series("fit", kTurningPoints, 40, {0.0, 0.01}),
                                          play_series("score", kTurningPoints, 40, {0.0, 1.0})};
  HistoriesOptions options;
  options.fitted = {"fit"};
  CHECK(histories_of(table, "t.csv", options).taxels[0].noise == Approx(0.01).epsilon(0.15));
  options.fitted = {"score"};
  CHECK(histories_of(table, "t.csv", options).taxels[0].noise == Approx(1.0).epsilon(0.15));
  options.noise = 0.5;
  CHECK(histories_of(table, "t.csv", options).taxels[0].noise == 0.5);
}

TEST_CASE("what is only scored changes neither the turns nor the noise of what is fitted") {
  const TableSeries fitted = play_series("fit", kTurningPoints, 40, {0.002, 0.01});
  TableSeries wide = play_series("score", {0, 30, 0, 30, 0}, 400, {0.5, 0.0});
  HistoriesOptions options;
  options.fitted = {"fit"};
  const TaxelHistories alone = histories_of({fitted}, "t.csv", options).taxels[0];
  const TaxelHistories both = histories_of({fitted, wide}, "t.csv", options).taxels[0];
  CHECK(both.turn == alone.turn);
  CHECK(both.noise == alone.noise);
  CHECK(both.fit[0].branches.size() == alone.fit[0].branches.size());
  CHECK(both.fit[1].branches.size() == 4);  // its own noise does not shred it
}

TEST_CASE("curvature and turns of a coarse table are not taken for noise") {
  TableSeries series{"1", 0, {}, {}};
  for (int cycle = 0; cycle < 5; ++cycle) {
    for (int i = 0; i < 40; ++i) {
      const double x = i < 20 ? -1.0 + i / 10.0 : 3.0 - i / 10.0;
      series.input.push_back(x);
      series.output.push_back(std::tanh(5.0 * x + (i < 20 ? -1.0 : 1.0)));
    }
  }
  CHECK(histories_of({series}, "t.csv").taxels[0].noise < 0.002 * 2.0);
}

TEST_CASE("turns are distinguished from the noise of the inputs, or by a stated size") {
  CHECK(branches_of(play_series("1", kTurningPoints, 200, {0.03, 0.0})) == kTurningPoints.size() - 1);
  CHECK(branches_of(play_series("1", kTurningPoints, 200)) == kTurningPoints.size() - 1);
  const TableSeries noisy = play_series("1", {0, 10, 0, 10, 5, 10, 0}, 200, {0.1, 0.0});
  CHECK(branches_of(noisy) == 6);
  const TableSeries wavers = play_series("1", {0, 6, 5.5, 10, 0}, 40);
  CHECK(branches_of(wavers) == 4);
  CHECK(branches_of(wavers, 0.4) == 4);
  CHECK(branches_of(wavers, 0.6) == 2);
}

TEST_CASE("measured sweeps that miss the extremes make the external loop, commanded ones do not") {
  const Histories histories = histories_of({play_series("1", {0.2, 10, 0.2, 9.75, 0, 9.75, 0.2}, 100)}, "t.csv");
  const FitData data = fit_data_of(histories.taxels[0], {});
  CHECK(data.no_loop.empty());
  CHECK(data.ascending.x().front() < 0.3);
  CHECK(data.ascending.x().back() > 9.7);
  std::vector<TaxelTable> sequences;
  for (const History& history : data.histories) sequences.push_back({history.x, history.y, history.branches});
  CHECK_THROWS_AS(external_loop(sequences, 1), AnalysisError);
  CHECK(external_loop(sequences, 1, 0.01).left_out > 0.0);
}

TEST_CASE("without an external loop the models that need none are fitted, the others say what is missing") {
  const Histories histories = histories_of({play_series("1", {0, 10, 4, 8, 3, 9, 5, 7, 2, 8, 4}, 40)}, "t.csv");
  const FitData data = fit_data_of(histories.taxels[0], {});
  CHECK_FALSE(data.no_loop.empty());
  for (const std::string model : {"gpi", "mpi", "preisach", "monotone"}) {
    INFO(model);
    const ModelFit fit = identify(model, data);
    CHECK(fit.full_scale == Approx(histories.taxels[0].fit[0].y[40] - histories.taxels[0].fit[0].y[0]).epsilon(0.05));
    CHECK(fit.mean_error < (model == "preisach" ? 0.02 : 0.1) * fit.full_scale);
  }
  for (const std::string model : {"elam", "poly"}) {
    INFO(model);
    CHECK(id_of_refusal([&] { return identify(model, data); }) == "TB-ANALYSIS-NO-LOOP");
  }
}
