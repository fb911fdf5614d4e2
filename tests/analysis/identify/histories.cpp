// Histories of taxels by hand: their mean, their sign, their loops and ends, and repeats that differ.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/error.h"
#include "analysis/identify/histories.h"
#include "tests/analysis/identify/refusals.h"

using namespace tactbench::analysis;

namespace {

TaxelHistories of_history(int taxel, const std::vector<double>& x, const std::vector<double>& y,
                          const std::string& name = "h") {
  TaxelHistories own;
  own.taxel = taxel;
  own.fit = own.score = {History{name, x, y, branches_along(x), {}, {}}};
  return own;
}

const std::vector<double> kWayUpAndDown{0, 50, 100, 50, 0};

Histories of_three() {
  Histories histories;
  histories.taxels = {of_history(0, kWayUpAndDown, {0, 1, 4, 3, 0}), of_history(1, kWayUpAndDown, {2, 4, 8, 5, 2}),
                      of_history(2, kWayUpAndDown, {9, 9, 9, 9, 9})};
  histories.taxels[0].noise = 0.3;
  histories.taxels[1].noise = 0.4;
  histories.taxels[0].turn = 1.0;
  histories.taxels[1].turn = 2.0;
  histories.taxels[2].noise = 50.0;
  histories.taxels[2].turn = 50.0;
  histories.taxels[2].status = TaxelStatus::kConstant;
  return histories;
}

Histories gathered(std::vector<TaxelHistories> taxels) {
  Histories histories;
  histories.source = "t";
  histories.taxels = std::move(taxels);
  finish(histories);
  return histories;
}

// One taxel at 0 and 10 psi; a repeat of each pair of outputs.
std::vector<RepeatDrift> drifts_of(const std::vector<std::pair<double, double>>& repeats, std::size_t taxels = 1) {
  Dataset dataset;
  dataset.rows = dataset.columns = 1;
  SequenceData sequence{"up", {}};
  for (const auto& [low, high] : repeats) sequence.repeats.push_back({{{0, 0}, {10, 10}}, {low, high}});
  dataset.sequences = {sequence};
  const std::size_t taxel = 0;
  return repeat_drifts(dataset, {&taxel, taxels}, {});
}

}  // namespace

TEST_CASE("mean taxel: outputs, noise and turn size come from the taxels that can be fitted, if their inputs agree") {
  Histories histories = of_three();
  finish(histories);
  REQUIRE(histories.taxels.size() == 4);
  const TaxelHistories& mean = histories.taxels.back();
  CHECK((mean.taxel == kMeanTaxel && mean.usable() && !histories.falling));
  CHECK(mean.fit[0].y == std::vector<double>{1, 2.5, 6, 4, 1});
  CHECK(mean.score[0].y == mean.fit[0].y);
  CHECK(mean.fit[0].x == kWayUpAndDown);
  CHECK(mean.noise == Approx(0.25));  // of the mean of two
  CHECK(mean.turn == 2.0);
  CHECK(mean_taxel_of(histories).taxels.size() == 1);
  CHECK(mean_taxel_of(histories).taxels[0].taxel == kMeanTaxel);
  Histories one;
  one.taxels = {of_history(7, kWayUpAndDown, {0, 1, 4, 3, 0})};
  finish(one);
  CHECK(one.taxels.size() == 1);
  CHECK(mean_taxel_of(one).taxels[0].taxel == 7);
  // Of other inputs there is no mean.
  Histories other = of_three();
  other.taxels[1].fit[0].x[1] = 49.0;
  finish(other);
  CHECK(other.taxels.size() == 3);
  CHECK(id_of_refusal([&] { return mean_taxel_of(other); }) == "TB-ANALYSIS-NO-TAXEL");
  Histories none = of_three();
  for (TaxelHistories& taxel : none.taxels) taxel.status = TaxelStatus::kDead;
  CHECK(id_of_refusal([&] { finish(none); }) == "TB-ANALYSIS-NO-TAXEL");
}

TEST_CASE("mean loop: averages each taxel's own loop, if all have the same inputs") {
  const Histories histories = of_three();
  const auto mean = mean_fit_data(histories, {0, 1}, {});
  REQUIRE(mean);
  CHECK(mean->histories[0].y == std::vector<double>{1, 2.5, 6, 4, 1});
  CHECK((mean->ascending(0) == 1.0 && mean->ascending(50) == 2.5 && mean->ascending(100) == 6.0));
  CHECK(mean->descending(50) == 4.0);
  const auto alone = mean_fit_data(histories, {1}, {"h"});
  CHECK(alone->ascending(50) == 4.0);
  Histories other = of_three();
  other.taxels[1].fit[0].x = {0, 40, 100, 40, 0};
  CHECK_FALSE(mean_fit_data(other, {0, 1}, {}));
  other = of_three();
  other.taxels[1].fit.push_back(other.taxels[1].fit[0]);
  CHECK_FALSE(mean_fit_data(other, {0, 1}, {}));
}

TEST_CASE("histories by name: come in the requested order, all of one name, and a missing name is refused") {
  const std::vector<History> histories{
      {"a", {1}, {}, {}, {}, {}}, {"b", {2}, {}, {}, {}, {}}, {"a", {3}, {}, {}, {}, {}}};
  const auto inputs = [&](const std::vector<std::string>& names) {
    std::vector<double> out;
    for (const History& history : named(histories, names)) out.push_back(history.x[0]);
    return out;
  };
  CHECK(inputs({}) == std::vector<double>{1, 2, 3});
  CHECK(inputs({"b", "a"}) == std::vector<double>{2, 1, 3});
  CHECK(id_of_refusal([&] { return named(histories, {"a", "c"}); }) == "TB-MODEL-SEQUENCE");
  const Span span = span_of({{"a", {4, 7}, {}, {}, {}, {}}, {"b", {9, -1}, {}, {}, {}, {}}}, &History::x);
  CHECK((span.low == -1.0 && span.high == 9.0 && span.length() == 10.0));
}

TEST_CASE("repeat drift: a first repeat differs beyond 3 uncertainties of its mean or twice the others' RMS") {
  // Others 0 and 0.02 with +-0.2 at the two steps: shifts of 0.02, uncertain by 0.02 sqrt(3/4); rms sqrt(0.0404) =
  // 0.201.
  const auto shifted = [](double shift) {
    return drifts_of({{0.01 + shift, 0.01 + shift}, {0.0, 0.0}, {0.22, -0.18}}).front();
  };
  CHECK(shifted(0.0).uncertainty_v == Approx(0.02 * std::sqrt(0.75)));
  CHECK(shifted(0.0).others_rms_v == Approx(std::sqrt(0.0404)));
  CHECK(shifted(0.0).shift_v == Approx(0.0).margin(1e-12));
  CHECK(shifted(0.0).rms_v == Approx(0.1));
  CHECK_FALSE(shifted(0.0515).differs);  // 2.97 of them
  CHECK(shifted(0.0525).differs);        // 3.03
  CHECK(shifted(-0.0525).differs);
  // Without a shift: +-w beside the others' mean, whose rms is 1.
  const auto waving = [](double wave) {
    return drifts_of({{0.5 + wave, -0.5 - wave}, {0.0, 0.0}, {1.0, -1.0}}).front();
  };
  CHECK(waving(1.99).rms_v == Approx(1.99));
  CHECK_FALSE(waving(1.99).differs);
  CHECK(waving(2.01).differs);
  CHECK(drifts_of({{0, 0}, {1, 1}}).empty());
  CHECK(drifts_of({{0, 0}, {1, 1}, {2, 2}}, 0).empty());
  CHECK(drifts_of({{0, 0}, {1, 1}, {2, 2}}).size() == 1);
}

TEST_CASE("histories: outputs are negated if they fall with the input over all usable taxels") {
  const std::vector<double> there_and_back{0, 1, 2, 1, 0};
  // Mean inputs are 0.8: of these outputs the sum of products is -3.2 and, of the second taxel, 1.6 times as much.
  const std::vector<double> falls{0, -1, -2, -1, 0}, rises{0, 2, 4, 2, 0};
  TaxelHistories stuck = of_history(2, there_and_back, {0, -100, -200, -100, 0});
  stuck.status = TaxelStatus::kSaturated;
  const Histories both = gathered({of_history(0, there_and_back, falls), of_history(1, there_and_back, rises), stuck});
  CHECK_FALSE(both.falling);
  CHECK(both.taxels[0].fit[0].y == falls);
  const Histories down = gathered({of_history(0, there_and_back, falls)});
  CHECK(down.falling);
  CHECK(down.taxels[0].fit[0].y == std::vector<double>{0, 1, 2, 1, 0});
  CHECK(down.taxels[0].score[0].y == std::vector<double>{0, 1, 2, 1, 0});
  CHECK_FALSE(gathered({of_history(0, there_and_back, {3, 3, 3, 3, 3})}).falling);
  // Each history about its own mean: a zero that moved between two is no fall.
  TaxelHistories shifted = of_history(0, there_and_back, rises);
  shifted.fit.push_back({"2", {10, 11, 12, 11, 10}, {-50, -48, -46, -48, -50}, {}, {}, {}});
  CHECK_FALSE(gathered({shifted}).falling);
}

TEST_CASE("fit data: both patterns start and end at the mean of the measured outputs, and must rise") {
  const std::vector<double> there_and_back{0, 1, 2, 1, 0};
  TaxelHistories taxel = of_history(0, {0, 1, 2, 2}, {0.2, 2, 5, 5});
  const std::vector<double> down{2, 1, 0, 0};
  taxel.fit.push_back({"2", down, {5.4, 3, 0.4, 0.4}, branches_along(down), {}, {}});
  const FitData data = fit_data_of(taxel, {});
  CHECK(data.no_loop.empty());
  CHECK(data.ascending.y()[0] == Approx(0.3));
  CHECK(data.ascending.y()[1] == 2.0);
  CHECK(data.ascending.y()[2] == Approx(5.2));
  CHECK(data.descending.y()[0] == Approx(0.3));
  CHECK(data.descending.y()[1] == 3.0);
  CHECK(data.descending.y()[2] == Approx(5.2));
  const auto rises_to = [&](double top) {
    const TaxelHistories own = of_history(0, there_and_back, {1, 2, top, 2, 1});
    return fit_data_of(own, {}).ascending.y().back();
  };
  CHECK(rises_to(1.5) == 1.5);
  CHECK_THROWS_AS(rises_to(1.0), AnalysisError);
  CHECK_THROWS_AS(rises_to(0.5), AnalysisError);
}
