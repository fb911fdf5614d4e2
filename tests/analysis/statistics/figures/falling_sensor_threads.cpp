// A sensor whose output falls with the pressure: every figure is that of the sensor with its outputs negated.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/mpe.h"
#include "analysis/report/results.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/effect_runs.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench::analysis;

namespace {

Dataset negated(Dataset data) {
  for (SequenceData& sequence : data.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (double& volts : repeat.volts) volts = -volts;
  return data;
}

SensorModel falling(SensorModel fit) {
  fit.falling = true;
  return fit;
}

}  // namespace

TEST_CASE("a falling sensor: errors, hysteresis, permissible errors and straight line as with outputs that rise") {
  const SensorModel fit = straight_array::straight_fit();
  const Dataset data = straight_array::known_loop();
  const Evaluation rising = evaluate(data, fit), found = evaluate(negated(data), falling(fit));
  CHECK(rising.mean_error_psi > 0.1);
  CHECK(found.mean_error_psi == Approx(rising.mean_error_psi));
  CHECK(found.comp_distance == Approx(rising.comp_distance));
  CHECK(found.raw_distance == Approx(rising.raw_distance));
  CHECK(found.full_scale_v == Approx(rising.full_scale_v));
  check_alike(found.taxel_mean_error_psi, rising.taxel_mean_error_psi);
  const Limits::Mpe whole[] = {{0.0, 60.0, 8.0, 0.95}};
  CHECK(mpe_figures(negated(data), falling(fit), nullptr, whole, 1).front().value_psi == Approx(6.0));
}

TEST_CASE("a falling sensor: errors of rates and holds, and the effect of the pace on the output") {
  const auto paced = [](double seconds, double more) {
    Repeat repeat;
    for (const int step : {0, 1, 2}) {
      repeat.steps.push_back({20.0 * step, 20.0 * step, seconds * step, 1.0});
      repeat.volts.insert(repeat.volts.end(), {step + more, 2.0 * step + more, 9.0});
    }
    return repeat;
  };
  const SensorModel fit = straight_array::straight_fit();
  const Dataset data = straight_array::dataset_of({{"rate", {paced(30, 0.25), paced(60, 0.0)}}});
  const RateHoldRun rising = rate_hold_of(data, fit).front();
  const RateHoldRun found = rate_hold_of(negated(data), falling(fit)).front();
  // The fast repeat stands 0.25 V over the slow one, of a full scale of 4.5 V; 5 and 2.5 psi.
  CHECK(found.output_max_share == Approx(0.25 / 4.5));
  CHECK(found.error.max == Approx(5.0));
  CHECK(found.error.sum == Approx(rising.error.sum));
}

TEST_CASE("a falling sensor: creep of holds and what a kelvin changes as with outputs that rise") {
  using namespace effect_runs;
  const Example example;
  const Dataset calibration = read_after(at_temperature(example, 23.0, 0.0, 0.0), 2.0);
  const std::vector<Dataset> warm{at_temperature(example, 28.0, -0.01, 0.02)}, held{hold_run(example, {})};
  const std::vector<Dataset> warm_negated{negated(warm[0])}, held_negated{negated(held[0])};
  const TemperatureEffect rising = temperature_effect_of(calibration, warm, example.fit, 0.1);
  const TemperatureEffect found = temperature_effect_of(negated(calibration), warm_negated, falling(example.fit), 0.1);
  REQUIRE((rising.assessed() && found.assessed()));
  CHECK(found.per_kelvin.share == Approx(rising.per_kelvin.share));
  CHECK(found.per_kelvin.zero_v == Approx(rising.per_kelvin.zero_v));
  CHECK(found.u.share == Approx(rising.u.share));
  const CreepEffect creep = creep_effect_of(calibration, held, example.fit);
  const CreepEffect fallen = creep_effect_of(negated(calibration), held_negated, falling(example.fit));
  REQUIRE((creep.levels.size() == 1 && fallen.levels.size() == 1));
  check_alike(fallen.levels[0].share, creep.levels[0].share);
  CHECK(fallen.read_after_s == creep.read_after_s);
}

TEST_CASE("a falling sensor: an array under an object as with outputs that rise, its volts as measured") {
  SensorModel fit = straight_array::straight_fit();
  PressRun run;
  run.origin = "simulated";
  run.sensor_serial = "S";
  run.rows = 1;
  run.columns = 3;
  for (const double volts : {1.0, 1.5}) {
    PressFrame frame;
    frame.rising = true;
    frame.target_n = 10.0 * volts;
    frame.force_n = 20.0;
    frame.volts = {-volts, -2.0 * volts, -9.0};
    run.frames.push_back(frame);
  }
  const ContactResult found = contact_result(run, falling(fit), {2.0, 1.0 / kNewtonPerPsiMm2});
  REQUIRE(found.levels.size() == 2);
  // 1 and 2 V are 20 psi by the taxels' own lines; by the mean's 40/3 psi a volt 13.3 and 26.7. 1 psi on a taxel is 1
  // N.
  CHECK(found.levels[0].compensated.force_n == Approx(40.0));
  CHECK(found.levels[0].raw.force_n == Approx(40.0));
  CHECK(found.levels[1].compensated.force_n == Approx(60.0));
  CHECK(found.levels[0].raw_v == std::vector<double>{-1.0, -2.0, -9.0});
}

TEST_CASE("a falling sensor: U of each condition of use as with outputs that rise, whichever runs tell it") {
  using namespace straight_array;
  const std::vector<double> loop{0, 20, 40, 60, 40, 20, 0};
  const auto run_of = [](std::int64_t number, SequenceData sequence) {
    Dataset run = dataset_of({std::move(sequence)});
    run.run = number;
    return run;
  };
  const Dataset calibration = run_of(2, {"loop", {offset_way(loop, 0.1, 0.1, 1), offset_way(loop, -0.1, -0.1, 1)}});
  // After full pressure, over the range.
  const std::vector<double> reversals{0, 60, 20, 40, 0, 40, 55, 5, 40, 0};
  const Dataset again = run_of(5, {"loop", {offset_way(loop, 0.3, 0.3, 1), offset_way(loop, 0.31, 0.31, 1)}});
  const Dataset one = run_of(6, {"other", {offset_way(reversals, 0.5, 0.5, 1)}}),
                two = run_of(7, {"other", {offset_way(reversals, 0.52, 0.52, 1)}}),
                slow = run_of(9, {"other", {offset_way(reversals, 0.5, 0.5, 10)}}),
                slow_again = run_of(10, {"other", {offset_way(reversals, 0.52, 0.52, 10)}});
  const Dataset paced = run_of(8, {"rate", {offset_way(loop, 0.0, 0.0, 1), offset_way(loop, 0.6, 0.6, 4)}});
  const auto assessed = [&](bool falls) {
    const auto as_measured = [&](const Dataset& data) { return falls ? negated(data) : data; };
    const std::vector<Dataset> runs{as_measured(again), as_measured(one),  as_measured(two),
                                    as_measured(paced), as_measured(slow), as_measured(slow_again)};
    UncertaintyInputs inputs;
    inputs.history.same = {&runs[0], &runs[1], &runs[2], &runs[4], &runs[5]};
    inputs.history.later = inputs.history.warm = inputs.history.mounted = {&runs[1], &runs[2]};
    inputs.history.paced = {&runs[3]};
    SensorModel fit = straight_fit();
    fit.falling = falls;
    return assess_uncertainty(as_measured(calibration), fit,
                              uncertainty_example::record_with_reference(uncertainty_example::kWithCertificate), inputs,
                              1);
  };
  const Uncertainty rising = assessed(false), found = assessed(true);
  CHECK(rising.dwell.run == 8);
  CHECK(found.dwell.run == 8);
  check_alike(found.dwell.square_psi, rising.dwell.square_psi);
  REQUIRE(found.levels.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    check_alike(found.levels[i].expanded_psi, rising.levels[i].expanded_psi);
    check_alike(found.levels[i].error_psi, rising.levels[i].error_psi);
  }
  for (std::size_t i = 0; i < rising.conditions.size(); ++i) {
    INFO("condition " << i);
    CHECK(found.conditions[i].not_valid == rising.conditions[i].not_valid);
    check_alike(found.conditions[i].expanded_psi, rising.conditions[i].expanded_psi);
  }
  // Those of which two histories tell are valid.
  for (const UseCondition told : {UseCondition::kFullSweeps, UseCondition::kReversals, UseCondition::kOtherDwell,
                                  UseCondition::kOtherTemperature, UseCondition::kRemounted, UseCondition::kLater})
    CHECK(found.condition(told).valid());
}
