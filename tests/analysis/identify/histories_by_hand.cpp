// Histories by hand: signs and the mean taxel, the loop's ends, and each limit beyond which a table's warning is told.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "analysis/statistics/numbers/difference_noise.h"

using namespace tactbench::analysis;

namespace {

using SeriesValues = std::vector<double>;

TaxelHistories one_history(int number, const SeriesValues& x, const SeriesValues& y, double noise = 0.0) {
  TaxelHistories taxel;
  taxel.taxel = number;
  taxel.noise = noise;
  taxel.fit = {{"1", x, y, branches_along(x), {}, {}}};
  taxel.score = taxel.fit;
  return taxel;
}

Histories gathered(std::vector<TaxelHistories> taxels) {
  Histories histories;
  histories.source = "t";
  histories.taxels = std::move(taxels);
  finish(histories);
  return histories;
}

// The output is the input, along turning points in steps of a quarter.
TableSeries straight_series(const std::string& name, const SeriesValues& turns, int taxel = 0) {
  TableSeries series{name, taxel, {turns.front()}, {}};
  for (const double turn : turns)
    while (std::abs(turn - series.input.back()) > 1e-9) {
      const double way = turn - series.input.back();
      series.input.push_back(series.input.back() + std::copysign(std::min(0.25, std::abs(way)), way));
    }
  series.output = series.input;
  return series;
}

std::string warned(const std::vector<TableSeries>& table, const HistoriesOptions& options = {}) {
  std::string text;
  for (const std::string& line : histories_of(table, "t.csv", options).warnings) text += line + "\n";
  return text;
}

std::string id_of_table(const std::vector<TableSeries>& table, const HistoriesOptions& options = {}) {
  try {
    (void)histories_of(table, "t.csv", options);
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return "none";
}

const SeriesValues kThereAndBack{0, 1, 2, 1, 0};
// Three turns inside the range either way.
const SeriesValues kEnoughTurns{0, 10, 2, 10, 2, 10, 2, 10, 0, 8, 0, 8, 0, 8, 0};

}  // namespace

TEST_CASE("histories by hand: the mean taxel is the usable ones' mean, its noise that of a mean") {
  TaxelHistories lost = one_history(1, kThereAndBack, {7, 7, 7, 7, 7}, 9.0);
  lost.status = TaxelStatus::kStuck;
  std::vector<TaxelHistories> taxels = {one_history(0, kThereAndBack, {0, 1, 4, 2, 0}, 0.3), lost,
                                        one_history(2, kThereAndBack, {1, 3, 6, 5, 1}, 0.4)};
  taxels[0].turn = 0.2;
  taxels[2].turn = 0.1;
  const Histories histories = gathered(taxels);
  REQUIRE(histories.taxels.size() == 4);
  const TaxelHistories& mean = histories.taxels.back();
  CHECK(mean.taxel == kMeanTaxel);
  CHECK(mean.noise == Approx(0.25));
  CHECK(mean.turn == 0.2);
  CHECK(mean.fit[0].y == SeriesValues{0.5, 2, 5, 3.5, 0.5});
  CHECK(mean.score[0].y == SeriesValues{0.5, 2, 5, 3.5, 0.5});
  CHECK_FALSE(histories.falling);
  // Their loop's mean.
  const auto data = mean_fit_data(histories, {0, 2}, {});
  REQUIRE(data);
  CHECK(data->ascending.y()[1] == 2.0);
  CHECK(data->descending.y()[1] == 3.5);
  CHECK(data->ascending.y()[0] == 0.5);
  CHECK(data->ascending.y()[2] == 5.0);
  CHECK(data->histories[0].y == SeriesValues{0.5, 2, 5, 3.5, 0.5});
  CHECK(mean_taxel_of(histories).taxels.size() == 1);
  CHECK(mean_taxel_of(histories).taxels[0].noise == Approx(0.25));
  // One taxel has no mean; inputs that differ give none; without a usable one there is nothing.
  CHECK(gathered({taxels[0]}).taxels.size() == 1);
  CHECK(mean_taxel_of(gathered({taxels[0]})).taxels.size() == 1);
  taxels[2].fit[0].x[1] = 1.5;
  CHECK(gathered(taxels).taxels.size() == 3);
  try {
    (void)mean_taxel_of(gathered(taxels));
    FAIL("no mean, and not refused");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-ANALYSIS-NO-TAXEL");
    CHECK_THAT(error.what(), Catch::Contains("there is no mean taxel, for the taxels' inputs differ"));
  }
  CHECK_FALSE(mean_fit_data(gathered(taxels), {0, 2}, {}));
  CHECK_THROWS_AS(gathered({lost}), AnalysisError);
}

TEST_CASE("histories by hand: outputs are negated where they fall with the input over all usable taxels") {
  // Mean inputs are 0.8: of these outputs the sum of products is -3.2 and, of the second taxel, 1.6 times as much.
  const SeriesValues falls{0, -1, -2, -1, 0}, rises{0, 2, 4, 2, 0};
  TaxelHistories stuck = one_history(2, kThereAndBack, {0, -100, -200, -100, 0});
  stuck.status = TaxelStatus::kSaturated;
  const Histories both = gathered({one_history(0, kThereAndBack, falls), one_history(1, kThereAndBack, rises), stuck});
  CHECK_FALSE(both.falling);
  CHECK(both.taxels[0].fit[0].y == falls);
  const Histories down = gathered({one_history(0, kThereAndBack, falls)});
  CHECK(down.falling);
  CHECK(down.taxels[0].fit[0].y == SeriesValues{0, 1, 2, 1, 0});
  CHECK(down.taxels[0].score[0].y == SeriesValues{0, 1, 2, 1, 0});
  CHECK_FALSE(gathered({one_history(0, kThereAndBack, {3, 3, 3, 3, 3})}).falling);
  // Each history about its own mean: a zero that moved between two is no fall.
  TaxelHistories shifted = one_history(0, kThereAndBack, rises);
  shifted.fit.push_back({"2", {10, 11, 12, 11, 10}, {-50, -48, -46, -48, -50}, {}, {}, {}});
  CHECK_FALSE(gathered({shifted}).falling);
}

TEST_CASE("histories by hand: both patterns begin and end in the mean of what was measured, or there is no rise") {
  TaxelHistories taxel = one_history(0, {0, 1, 2, 2}, {0.2, 2, 5, 5});
  const SeriesValues down{2, 1, 0, 0};
  taxel.fit.push_back({"2", down, {5.4, 3, 0.4, 0.4}, branches_along(down), {}, {}});
  const FitData data = fit_data_of(taxel, {});
  CHECK(data.no_loop.empty());
  CHECK(data.ascending.y()[0] == Approx(0.3));
  CHECK(data.ascending.y()[1] == 2.0);
  CHECK(data.ascending.y()[2] == Approx(5.2));
  CHECK(data.descending.y()[0] == Approx(0.3));
  CHECK(data.descending.y()[1] == 3.0);
  CHECK(data.descending.y()[2] == Approx(5.2));
  const auto rises_to = [](double top) {
    const TaxelHistories own = one_history(0, kThereAndBack, {1, 2, top, 2, 1});
    return fit_data_of(own, {}).ascending.y().back();
  };
  CHECK(rises_to(1.5) == 1.5);
  CHECK_THROWS_AS(rises_to(1.0), AnalysisError);
  CHECK_THROWS_AS(rises_to(0.5), AnalysisError);
}

TEST_CASE("histories by hand: without a loop the ends are mean outputs within a hundredth of the inputs' ends") {
  const SeriesValues x{0, 10, 5, 9.9, 2, 6, 0.1, 0.12}, y{1, 9, 4, 8, 2, 5, 3, 6};
  const FitData data = fit_data_of(one_history(0, x, y), {});
  CHECK_FALSE(data.no_loop.empty());
  REQUIRE(data.ascending.x().size() == 2);
  CHECK(data.ascending.x()[0] == 0.0);
  CHECK(data.ascending.x()[1] == 10.0);
  CHECK(data.ascending.y()[0] == Approx(2.0));  // 1 and 3
  CHECK(data.ascending.y()[1] == Approx(8.5));  // 9 and 8
  CHECK(data.descending.y()[0] == Approx(2.0));
  CHECK(data.descending.y()[1] == Approx(8.5));
  const Span span = span_of({{"1", x, y, {}, {}, {}}, {"2", {-3, 4}, {0, 12}, {}, {}, {}}}, &History::x);
  CHECK(span.low == -3.0);
  CHECK(span.high == 10.0);
  CHECK(span.length() == 13.0);
}

TEST_CASE("tables by hand: four samples, inputs that change, a turn below their span") {
  CHECK(id_of_table({{"1", 0, {0, 1, 0}, {0, 1, 0}}}) == "TB-TABLE-SHORT");
  CHECK(id_of_table({{"1", 0, {0, 1, 1, 0}, {0, 1, 1, 0}}}) == "none");
  CHECK(id_of_table({{"1", 0, {2, 2, 2, 2}, {0, 1, 1, 0}}}) == "TB-TABLE-CONSTANT");
  const std::vector<TableSeries> table = {straight_series("1", {0, 4, 0})};
  HistoriesOptions options;
  for (const auto& [turn, id] : {std::pair{4.0, "TB-TABLE-TURN"}, {3.9, "none"}, {0.0, "none"}}) {
    options.turn = turn;
    CHECK(id_of_table(table, options) == id);
  }
  options.turn = 0.0;
  CHECK(histories_of(table, "t", options).taxels[0].turn == 0.0);
  options.noise = 0.0;
  CHECK(histories_of({straight_series("1", {0, 4, 0}), straight_series("1", {0, 4, 0}, 1)}, "t", options).rows == 2);
  CHECK(histories_of(table, "t", options).taxels[0].noise == 0.0);
}

TEST_CASE("tables by hand: a turn is seven noises of the inputs, a thousandth of their span, or where they jump that") {
  for (const std::size_t count : {49U, 50U})
    for (double size = 0.001; size < 8.0; size *= 1.3) {
      TableSeries series{"1", 0, {}, {}};
      for (std::size_t i = 0; i < count; ++i) {
        const double jitter = size * (static_cast<double>((i * 37 + 11) % 29) / 14.0 - 1.0);
        series.input.push_back(10.0 * static_cast<double>(i) / static_cast<double>(count) + jitter);
        series.output.push_back(series.input.back());
      }
      const auto [low, high] = std::ranges::minmax(series.input);
      const double span = high - low;
      const double noises = count < 50 ? 0.0 : 7.0 * difference_noise(std::vector<Stretch>{{{}, series.input}});
      const Histories histories = histories_of({series}, "t");
      CAPTURE(count, size, noises / span);
      CHECK(histories.taxels[0].turn ==
            Approx(noises > 0.25 * span ? 0.001 * span : std::max(0.001 * span, noises)).epsilon(1e-12));
      std::string told;
      for (const std::string& line : histories.warnings) told += line + "\n";
      CHECK((told.find("the inputs are noisy") != std::string::npos) ==
            (noises > 0.02 * span && noises <= 0.25 * span));
      CHECK((told.find("the inputs jump") != std::string::npos) == (noises > 0.25 * span));
    }
}

TEST_CASE("tables by hand: a start further than a hundredth from both ends is told, up to three names") {
  const auto starts = [](double from, double to) {
    return warned({straight_series("a", kEnoughTurns), straight_series("b", {from, to, from})});
  };
  // The inputs span 10: 0.1 from an end is at it.
  CHECK(starts(0.1, 10.0).empty());
  CHECK_THAT(starts(0.125, 10.0),
             Catch::Contains("1 of 2 sequences starts in mid-range (\"b\"; the first at 0.125, 1 %"));
  CHECK(starts(9.9375, 0.0).empty());
  CHECK_THAT(starts(9.875, 0.0),
             Catch::Contains("1 of 2 sequences starts in mid-range (\"b\"; the first at 9.875, 99 %"));
  std::vector<TableSeries> many = {straight_series("a", kEnoughTurns)};
  for (const char* const name : {"b", "c", "d"}) many.push_back(straight_series(name, {4, 10, 0}));
  CHECK_THAT(warned(many),
             Catch::Contains("3 of 4 sequences start in mid-range (\"b\", \"c\", \"d\"; the first at 4, 40 %"));
  many.push_back(straight_series("e", {4, 10, 0}));
  CHECK_THAT(warned(many), Catch::Contains("(\"b\", \"c\", \"d\" and 1 more; the first at 4"));
}

TEST_CASE("tables by hand: three turns inside the range either way are enough, those at its ends do not count") {
  const auto few = [](const SeriesValues& turns) { return warned({straight_series("1", turns)}); };
  CHECK(few(kEnoughTurns).empty());
  CHECK_THAT(few({0, 10, 2, 10, 2, 10, 0, 8, 0, 8, 0, 8, 0}),
             Catch::Contains("3 branches begin there and fall, 2 rise"));
  CHECK_THAT(few({0, 10, 2, 10, 2, 10, 2, 10, 0, 8, 0, 8, 0}),
             Catch::Contains("2 branches begin there and fall, 3 rise"));
  CHECK_THAT(few({0, 10, 2, 10, 2, 10, 0.1, 10, 0, 8, 0, 8, 0, 9.9375, 0}),
             Catch::Contains("2 branches begin there and fall, 2 rise, 3 each"));
  CHECK(few({0, 10, 2, 10, 2, 10, 0.125, 10, 0, 8, 0, 8, 0, 9.875, 0}).empty());
}

TEST_CASE("tables by hand: a dead band of more than a fiftieth of the outputs' span is told, the widest of all") {
  HistoriesOptions options;
  const auto told = [&](double noise, const std::vector<TableSeries>& table) {
    options.noise = noise;
    return warned(table, options);
  };
  const std::vector<TableSeries> one = {straight_series("1", kEnoughTurns)};
  CHECK(told(0.0333, one).empty());
  CHECK_THAT(told(0.0334, one),
             Catch::Contains("the dead band of compensation is 2 % of the outputs' span (six times a "
                             "noise of 0.0334): lesser"));
  CHECK_THAT(told(0.1, one), Catch::Contains("is 6 % of the outputs' span (six times a noise of 0.1)"));
  std::vector<TableSeries> two = {one[0], straight_series("1", kEnoughTurns, 1)};
  for (double& y : two[1].output) y *= 0.5;
  CHECK_THAT(told(0.02, two),
             Catch::Contains("is 2.4 % of the outputs' span (six times a noise of 0.02, taxel 1, 1 above 2 %)"));
  CHECK_THAT(told(0.05, two),
             Catch::Contains("is 6 % of the outputs' span (six times a noise of 0.05, taxel 1, 2 above 2 %)"));
}
