// Histories of taxels by hand: their mean, their sign, their loops and ends, and repeats that differ; validity, folds
// and states of models; streams of single-valued models.

#include <catch2/catch.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "analysis/compensate/document.h"
#include "analysis/error.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/monotone.h"
#include "tests/analysis/support/fit_samples.h"

using namespace tactbench::analysis;
using namespace tactbench;

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

TEST_CASE("mean loop: averages the taxels' loops if all have the same inputs") {
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

// Facts that models store about their data: validity, folds, taxels' states and stored fits, by hand.

namespace {

SensorModel valid_within() {
  SensorModel model;
  model.validity.input = Range{10.0, 60.0};
  model.validity.hold_s = Range{2.0, 20.0};
  model.validity.rate = Range{1.0, 5.0};
  model.validity.temperature_c = Range{20.0, 22.0};
  return model;
}

std::size_t outside_of(const SensorModel& model, const std::vector<double>& x, const std::vector<double>& time_s,
                       const std::vector<double>& held_s, double celsius = 21.0,
                       const std::pair<std::string, std::string>& serials = {}) {
  Histories used;
  used.sensor_serial = serials.first;
  used.scanner_serial = serials.second;
  used.temperatures_c = {celsius};
  TaxelHistories dead, own;
  dead.status = TaxelStatus::kDead;
  own.score = {{"h", x, x, {}, time_s, held_s}};
  used.taxels = {dead, own};
  return outside_validity(model, used).size();
}

}  // namespace

TEST_CASE("validity: inputs cover all samples, holds and rates start at the second sample") {
  const std::vector<History> histories{{"a", {5, 10, 10, 40}, {}, {}, {0, 2, 2, 7}, {9, 1, 4, 3}},
                                       {"b", {50, -1}, {}, {}, {}, {}}};
  const Validity found = validity_of(histories, {23.0, 21.0});
  CHECK((found.input->low == -1.0 && found.input->high == 50.0));
  CHECK((found.hold_s->low == 1.0 && found.hold_s->high == 4.0));
  CHECK((found.rate->low == Approx(2.5) && found.rate->high == Approx(6.0)));  // no time passed: no rate
  CHECK((found.temperature_c->low == 21.0 && found.temperature_c->high == 23.0));
  const Validity none = validity_of({}, {});
  CHECK_FALSE((none.input || none.hold_s || none.rate || none.temperature_c));
  const Range range{1.0, 2.0};
  CHECK((range.contains(1.0) && range.contains(2.0) && !range.contains(0.99) && !range.contains(2.01)));
  CHECK(
      (range.contains(0.5, 0.5) && range.contains(2.5, 0.5) && !range.contains(0.4, 0.5) && !range.contains(2.6, 0.5)));
}

TEST_CASE("validity: allows 2 % of the range for inputs, 10 % for holds and rates, 1 K for temperatures") {
  const auto inputs = [](double low, double high) { return outside_of(valid_within(), {low, high}, {0, 50}, {2, 2}); };
  const auto held = [](double seconds) { return outside_of(valid_within(), {10, 20}, {0, 5}, {0, seconds}); };
  const auto rate = [](double psi_a_second) {
    return outside_of(valid_within(), {10, 20}, {0, 10 / psi_a_second}, {2, 2});
  };
  const auto at = [](double celsius) { return outside_of(valid_within(), {10, 20}, {0, 5}, {2, 2}, celsius); };
  for (const std::size_t inside :
       {inputs(9.01, 60.99), held(1.81), held(21.9), rate(0.001), rate(5.49), at(19.01), at(22.99)})
    CHECK(inside == 0);
  for (const std::size_t outside :
       {inputs(8.99, 60), inputs(10, 61.01), held(1.79), held(22.1), rate(5.51), at(18.99), at(23.01)})
    CHECK(outside == 1);
  // Of what is not known nothing is said.
  CHECK(outside_of(SensorModel(), {-99, 999}, {0, 1}, {0, 999}, 99) == 0);
  SensorModel sensor = valid_within();
  sensor.sensor_serial = "A";
  sensor.scanner_serial = "C";
  for (const auto& [own, other, outside] :
       {std::tuple{"A", "C", 0U}, {"B", "C", 1U}, {"A", "D", 1U}, {"B", "D", 2U}, {"", "", 0U}}) {
    CAPTURE(own, other);
    CHECK(outside_of(sensor, {10, 20}, {0, 5}, {2, 2}, 21.0, {own, other}) == outside);
  }
}

TEST_CASE("folds: branches starting more than 1 % of the range from an end are dealt out in turn") {
  const auto folds_with = [](double from, int most) {
    FitData data;
    const std::vector<double> ends{0, 100}, y{0, 1};
    data.ascending = data.descending = PatternCurve(ends, y, 0.0, 1.0);
    History history{"h", {0, 100, 100 - from, 60, from, 100, 0}, {}, {}, {}, {}};
    history.branches = {{0, 1, true}, {1, 2, false}, {2, 3, false}, {3, 4, false}, {4, 5, true}, {5, 6, false}};
    data.histories = {history};
    return folds_of(data, most);
  };
  // Falling from 99.01: external; from 60: inner; rising from 0.99: external. One inner branch is too few.
  CHECK(folds_with(0.99, 5).empty());
  const std::vector<Fold> folds = folds_with(1.01, 5);
  REQUIRE(folds.size() == 3);
  for (std::size_t f = 0; f < 3; ++f) {
    REQUIRE(folds[f].held[0].size() == 1);
    CHECK(folds[f].held[0][0].first == static_cast<int>(f) + 2);
    CHECK(folds[f].kept[0].size() == 5);
  }
  const std::vector<Fold> two = folds_with(1.01, 2);
  REQUIRE(two.size() == 2);
  CHECK(two[0].held[0].size() == 2);
  CHECK((two[0].held[0][0].first == 2 && two[0].held[0][1].first == 4 && two[1].held[0][0].first == 3));
}

TEST_CASE("TaxelStatus: converts to and from its name, and is decided at the voltage bound") {
  using Row = std::pair<TaxelStatus, const char*>;
  const Row rows[] = {{TaxelStatus::kFitted, "fitted"}, {TaxelStatus::kDead, "dead"},
                      {TaxelStatus::kStuck, "stuck"},   {TaxelStatus::kSaturated, "saturated"},
                      {TaxelStatus::kUnfit, "unfit"},   {TaxelStatus::kConstant, "constant"}};
  for (const auto& [status, word] : rows) {
    CHECK(std::string(to_string(status)) == word);
    TaxelStatus read = TaxelStatus::kUnfit;
    CHECK(status_from(word, read));
    CHECK(read == status);
  }
  TaxelStatus kept = TaxelStatus::kStuck;
  CHECK_FALSE(status_from("Dead", kept));
  CHECK(kept == TaxelStatus::kStuck);
  // 0.5 and 0.25 are exact in binary.
  CHECK(status_of({0.0, 0.25}, false, 0.25) == TaxelStatus::kFitted);
  CHECK(status_of({0.0, 0.2499}, false, 0.25) == TaxelStatus::kDead);
  CHECK(status_of({0.125, 0.25}, false, 0.25) == TaxelStatus::kStuck);
  CHECK(status_of({-0.25, -0.125}, false, 0.25) == TaxelStatus::kStuck);
  CHECK(status_of({-0.2499, -0.125}, false, 0.25) == TaxelStatus::kDead);
  CHECK(status_of({0.0, 9.0}, true, 0.25) == TaxelStatus::kSaturated);
}

// Streams of single-valued models by hand: what frames say of each taxel, what is left over.

namespace {

// Output = 1 + input / 10, from 0 to 60 psi.
ModelTaxel rising_line(int number, double noise = 0.0) {
  const std::vector<double> ends{0.0, 60.0}, volts{1.0, 7.0};
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = TaxelStatus::kFitted;
  taxel.noise = noise;
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, volts, 1.0, 7.0));
  taxel.fit.full_scale = 6.0;
  taxel.loop_low = 1.0;
  taxel.ascending = taxel.descending = PatternCurve(ends, volts, 1.0, 7.0);
  return taxel;
}

SensorModel line_array() {
  SensorModel model;
  model.model = "monotone";
  model.source = "run 3";
  model.rows = 1;
  model.columns = 3;
  model.pressure_psi = {0.0, 60.0};
  model.taxels = {rising_line(0), rising_line(1), ModelTaxel(), rising_line(-1)};
  model.taxels[2].taxel = 2;
  model.taxels[2].status = TaxelStatus::kStuck;
  return model;
}

struct FrameOut {
  std::vector<float> pressure = std::vector<float>(3), uncertainty = std::vector<float>(3);
  std::vector<std::uint16_t> status = std::vector<std::uint16_t>(3);
  FrameCompensator::Output output() { return {pressure, uncertainty, status}; }
};

std::vector<double> levels_of(const ModelTaxel& taxel) {
  return residual_by_level(taxel.ascending, taxel.descending, taxel.residual_psi);
}

}  // namespace

TEST_CASE("FrameCompensator: pressures and status bits of single-valued taxels match hand-computed values") {
  const SensorModel model = line_array();
  FrameCompensator stream = frames_of(model, 1.0, 2);
  FrameOut out;
  stream.frame(std::vector<float>{3.0F, 7.2F, 2.0F}, 0.0, out.output());
  CHECK(out.pressure[0] == Approx(20.0));
  CHECK(out.pressure[1] == Approx(60.0));
  CHECK((out.status[0] == kTaxelValid && out.status[1] == kTaxelValid && out.status[2] == kTaxelDead));
  CHECK((out.pressure[2] == 0.0F && out.uncertainty[2] == 60.0F));
  stream.frame(std::vector<float>{std::nanf(""), 2.0F, 2.0F}, 0.0, out.output());
  CHECK((out.status[0] == kTaxelLost && out.status[1] == kTaxelValid && out.status[2] == kTaxelDead));
  CHECK(out.pressure[0] == Approx(20.0));
  CHECK(out.pressure[1] == Approx(10.0));
  stream.lost_frame(0.0, out.output());
  CHECK((out.status[0] == kTaxelLost && out.status[1] == kTaxelLost && out.status[2] == kTaxelDead));
  CHECK(out.pressure[1] == Approx(10.0));
  stream.set_outside_validity(true);
  stream.frame(std::vector<float>{4.0F, 7.2F, 2.0F}, 0.0, out.output());
  CHECK((out.status[0] == kTaxelOutside && out.status[1] == kTaxelOutside && out.status[2] == kTaxelDead));
  stream.set_outside_validity(false);
  stream.frame(std::vector<float>{4.0F, 0.8F, 2.0F}, 0.0, out.output());
  CHECK((out.status[0] == kTaxelValid && out.status[1] == kTaxelValid));
  CHECK(out.pressure[1] == Approx(0.0).margin(1e-6));
}

TEST_CASE("FrameCompensator: falling outputs are read as measured, and part of an array is refused") {
  SensorModel model = line_array();
  model.falling = true;
  FrameCompensator stream = frames_of(model, 1.0, 2);
  FrameOut out;
  stream.frame(std::vector<float>{-3.0F, -2.0F, 0.0F}, 0.0, out.output());
  CHECK(out.pressure[0] == Approx(20.0));
  CHECK(out.pressure[1] == Approx(10.0));
  model.rows = 2;
  CHECK(id_of_refusal([&] { (void)frames_of(model); }) == "TB-MODEL-COMPENSATOR");
}

TEST_CASE("residual by level: grows with the flatness of each of 20 levels, from 0.5 to 4 times the residual") {
  ModelTaxel taxel = rising_line(0);
  CHECK(levels_of(taxel).empty());
  taxel.residual_psi = 0.5;
  CHECK(levels_of(taxel).size() == 40);
  for (const double psi : levels_of(taxel)) CHECK(psi == Approx(0.5));
  // Levels of 3 psi. Up: a quarter of the rise in the lower half, twice and two thirds of the mean. Down: six tenths
  // of it over the first level, 0.4 and 0.45 % over the next two.
  const std::vector<double> half{0, 30, 60}, half_y{0, 1, 4}, uneven{0, 3, 6, 9, 60}, uneven_y{0, 6, 6.04, 6.085, 10};
  taxel.ascending = PatternCurve(half, half_y, 0.0, 4.0);
  taxel.descending = PatternCurve(uneven, uneven_y, 0.0, 10.0);
  // The rise is that of the way up: 4. Of 10 the way down over its first level has 6, 0.04 and 0.045: own slopes of
  // 120, 0.8 and 0.9 against 4: 1/30, 5 and 4.44 times; the rest 3.915 over 17 levels: 4.606.
  const std::vector<double> psi = levels_of(taxel);
  CHECK(psi[0] == Approx(0.5 * 2.0));
  CHECK(psi[9] == Approx(0.5 * 2.0));
  CHECK(psi[10] == Approx(0.5 * 2.0 / 3.0));
  CHECK(psi[20] == Approx(0.5 * 0.5));
  CHECK(psi[21] == Approx(0.5 * 4.0));  // no more
  CHECK(psi[25] == Approx(0.5 * 4.0 * 17.0 / 20.0 / 3.915));
  // 3.1 and 4.1 times as flat as the mean.
  const std::vector<double> flat_y{0, 3.7, 3.7645, 3.8133, 4};
  taxel.descending = PatternCurve(uneven, flat_y, 0.0, 4.0);
  CHECK(levels_of(taxel)[21] == Approx(0.5 * 0.2 / 0.0645));
  CHECK(levels_of(taxel)[22] == Approx(0.5 * 4.0));
}
