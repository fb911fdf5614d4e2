// The scale of U on an array of more taxels than are asked: of 128 every second one tells, by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/uncertainty/budget_maker.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

constexpr std::size_t kManyTaxels = 128;

// Once along the set-points; even taxels err by `even`, odd ones by `odd`, 20 psi a volt each.
SequenceData way_of_many(const std::string& name, const std::vector<double>& setpoints, double even, double odd,
                         int repeats = 1) {
  Repeat repeat;
  for (const double psi : setpoints) {
    repeat.steps.push_back({psi, psi, 0.0, 1.0});
    for (std::size_t taxel = 0; taxel < kManyTaxels; ++taxel)
      repeat.volts.push_back((psi + (taxel % 2 == 0 ? even : odd)) / 20.0);
  }
  return {name, std::vector<Repeat>(static_cast<std::size_t>(repeats), repeat)};
}

Dataset many_of(std::vector<SequenceData> sequences, std::int64_t run) {
  Dataset data = dataset_of(std::move(sequences));
  data.run = run;
  data.columns = static_cast<int>(kManyTaxels);
  data.noise_v.assign(kManyTaxels, 0.0);
  data.at_limit.assign(kManyTaxels, false);
  return data;
}

Dataset held_out_of_many(std::int64_t run, double even, double odd) {
  std::vector<SequenceData> sequences;
  for (const char* name : {"a", "b", "c", "d"}) sequences.push_back(way_of_many(name, {0, 20, 40, 20}, even, odd));
  return many_of(std::move(sequences), run);
}

}  // namespace

TEST_CASE("coverage scale: of 128 taxels 64 tell, every second one from the first on") {
  SensorModel fit;
  fit.rows = 1;
  fit.columns = static_cast<int>(kManyTaxels);
  fit.origin = "simulated";
  fit.sensor_serial = "S";
  fit.pressure_psi = straight_array::kLevels;
  fit.taxels.assign(kManyTaxels, straight_taxel(20.0));
  by_hand::finish(fit, straight_taxel(20.0));
  const Dataset calibration = many_of({way_of_many("loop", {0, 20, 40, 60, 40, 20, 0}, 0.0, 0.0, 2)}, 2);
  const SweepErrors errors = sweep_errors(calibration, fit, 1);
  ReferenceUncertainty reference;
  reference.certificate_missing = reference.drift_missing = reference.resolution_missing = "none";
  // The even taxels err by 0.5 and 0.55 psi: each run is held against U of the other, k of four ways 2.87. The odd ones
  // err by 0.5 and 0.9, which nobody asks.
  const Dataset one = held_out_of_many(5, 0.5, 0.5), two = held_out_of_many(6, 0.55, 0.9);
  UncertaintyInputs inputs;
  inputs.history.same = {&one, &two};
  const BudgetMaker maker(calibration, fit, errors, reference, 0.0, inputs, 1);
  CHECK(maker.scale_of(UseCondition::kAnyHistory) == Approx(0.55 / (2.87 * 0.5)).epsilon(0.002));
}
