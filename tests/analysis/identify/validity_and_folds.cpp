// Facts that models store about their data: validity, folds, taxels' states and stored fits, by hand.
#include <catch2/catch.hpp>
#include <string>
#include <tuple>
#include <utility>

#include "analysis/identify/fit_samples.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"

using namespace tactbench;
using namespace tactbench::analysis;

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

// Inputs alone, held within the box and slow enough.
std::size_t inputs_outside(double low, double high) { return outside_of(valid_within(), {low, high}, {0, 50}, {2, 2}); }

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
  CHECK(inputs_outside(9.01, 60.99) == 0);
  CHECK(inputs_outside(8.99, 60) == 1);
  CHECK(inputs_outside(10, 61.01) == 1);
  const auto held = [](double seconds) { return outside_of(valid_within(), {10, 20}, {0, 5}, {0, seconds}); };
  CHECK(held(1.81) == 0);
  CHECK(held(1.79) == 1);
  CHECK(held(21.9) == 0);
  CHECK(held(22.1) == 1);
  const auto rate = [](double psi_a_second) {
    return outside_of(valid_within(), {10, 20}, {0, 10 / psi_a_second}, {2, 2});
  };
  CHECK(rate(0.001) == 0);
  CHECK(rate(5.49) == 0);
  CHECK(rate(5.51) == 1);
  const auto at = [](double celsius) { return outside_of(valid_within(), {10, 20}, {0, 5}, {2, 2}, celsius); };
  CHECK((at(19.01) == 0 && at(22.99) == 0));
  CHECK(at(18.99) == 1);
  CHECK(at(23.01) == 1);
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
  for (const auto& [status, word] :
       {std::pair{TaxelStatus::kFitted, "fitted"}, std::pair{TaxelStatus::kDead, "dead"},
        std::pair{TaxelStatus::kStuck, "stuck"}, std::pair{TaxelStatus::kSaturated, "saturated"},
        std::pair{TaxelStatus::kUnfit, "unfit"}, std::pair{TaxelStatus::kConstant, "constant"}}) {
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
