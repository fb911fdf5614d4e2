// U of a reading between levels, and what temperature adds, as functions of their own: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/temperature_effect.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

TEST_CASE("U between levels by hand: linear between levels of its branch, constant beyond them, none where none is") {
  ConditionUncertainty condition;
  condition.pressure_psi = {20, 40, 60, 30, 50};
  condition.up = {true, true, true, false, false};
  condition.expanded_psi = {1, 10, 3, 30, 4, 40, 5, 50, 9, 90};  // two taxels
  condition.error_psi = {0.1, 1, 0.2, 2, 0.4, 4, -0.5, -5, -0.7, -7};
  const auto at = [&](double psi, bool up, std::size_t taxel = 0) {
    return reading_uncertainty(condition, taxel, psi, up);
  };
  CHECK((at(10, true).expanded_psi == 1.0 && at(10, true).error_psi == 0.1));
  CHECK((at(20, true).expanded_psi == 1.0 && at(40, true).expanded_psi == 3.0));
  CHECK(at(25, true).expanded_psi == Approx(1.5));
  CHECK(at(25, true).error_psi == Approx(0.125));
  CHECK(at(55, true, 1).expanded_psi == Approx(37.5));
  CHECK(at(55, true, 1).error_psi == Approx(3.5));
  CHECK(at(70, true).expanded_psi == 4.0);
  CHECK(at(35, false).expanded_psi == Approx(6.0));
  CHECK((at(20, false, 1).expanded_psi == 50.0 && at(55, false, 1).error_psi == -7.0));
  condition.pressure_psi.resize(3);
  condition.up.resize(3);
  condition.expanded_psi.resize(6);
  condition.error_psi.resize(6);
  CHECK(std::isnan(at(30, false).expanded_psi));
  CHECK(std::isnan(at(30, false).error_psi));
  CHECK(std::isnan(reading_uncertainty({}, 0, 30, true).expanded_psi));
}

TEST_CASE("each condition of use and source has a name of its own") {
  std::set<std::string> conditions, sources;
  for (std::size_t condition = 0; condition < kUseConditions; ++condition)
    conditions.insert(name_of(static_cast<UseCondition>(condition)));
  for (std::size_t source = 0; source < kUncertaintySources; ++source)
    sources.insert(text_of(static_cast<UncertaintySource>(source)).name);
  CHECK((conditions.size() == kUseConditions && !conditions.contains("")));
  CHECK((sources.size() == kUncertaintySources && !sources.contains("")));
}

namespace {

// Up and down over the levels at a temperature: 0.1 V a psi and `share` more of it, `zero` higher; of the repeats one
// has `off` less, the other more.
Dataset loop_at(double celsius, double share, double zero, const std::vector<double>& rising, double off = 0.0) {
  Dataset data = dataset_of({});
  data.temperatures_c = {celsius};
  SequenceData sequence{"loop", {}};
  for (const double side : {-off, off}) {
    std::vector<double> psi = rising;
    for (std::size_t i = rising.size() - 1; i-- > 0;) psi.push_back(rising[i]);
    Repeat repeat;
    for (const double level : psi) {
      repeat.steps.push_back({level, level});
      const double volts = 0.5 + zero + 0.1 * level * (1.0 + share + side);
      repeat.volts.insert(repeat.volts.end(), {volts, volts, 9.0});
    }
    sequence.repeats.push_back(repeat);
  }
  data.sequences = {sequence};
  return data;
}
const std::vector<double> kFive{0, 15, 30, 45, 60};

TemperatureEffect of_runs(const Dataset& calibration, const std::vector<Dataset>& others) {
  return temperature_effect_of(calibration, others, straight_fit(), 0.1);
}

}  // namespace

TEST_CASE("temperature bounds: five levels in common within a millionth, and two kelvin between the means") {
  const auto assessed = [](double celsius, const std::vector<double>& rising) {
    return of_runs(loop_at(20, 0, 0, kFive, 0.01), {loop_at(celsius, 0.02, 0, rising, 0.01)}).assessed();
  };
  CHECK(assessed(22, kFive));
  CHECK_FALSE(assessed(21.99, kFive));
  CHECK(assessed(18, kFive));
  CHECK_FALSE(assessed(18.01, kFive));
  CHECK_FALSE(assessed(25, {0, 20, 40, 60}));
  CHECK(assessed(25, {0, 15 + 5e-7, 30, 45, 60}));
  CHECK_FALSE(assessed(25, {0, 15 + 2e-6, 30, 45, 60}));
  CHECK_FALSE(of_runs(loop_at(20, 0, 0, {0, 20, 40, 60}), {loop_at(25, 0, 0, kFive)}).not_assessed.empty());
  const std::vector<double> cold{19.0, 21.0}, warm{22.0}, close{21.9};
  CHECK(at_another_temperature(cold, warm));
  CHECK(at_another_temperature(warm, cold));
  CHECK_FALSE(at_another_temperature(cold, close));
  CHECK_FALSE(at_another_temperature(cold, {}));
}
