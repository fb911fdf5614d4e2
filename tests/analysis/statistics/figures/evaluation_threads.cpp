// Every figure of an evaluation against answers worked out on paper, on the straight taxels of straight_array.h: going
// up both read the reference, going down they are off by (1, 6) and (3, 1) psi at 40 and 20 psi.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/mpe.h"
#include "analysis/report/results.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/synthetic.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace straight_array;

namespace {

void check_values(const std::vector<double>& found, const std::vector<double>& wanted) {
  check_alike(found, wanted, 1e-9);
}

// The same with 60 mV of noise at the second taxel: four times that is 0.24 V, 2.4 psi, so that all it says is weak.
SensorModel noisy_fit() {
  SensorModel fit = straight_fit();
  fit.taxels[1].noise = 0.06;
  return fit;
}

}  // namespace

TEST_CASE("evaluate: averages over levels, taxels and frames match hand-computed values") {
  const Evaluation e = evaluate(known_loop(), straight_fit());
  CHECK(e.full_scale_v == Approx(4.5));
  CHECK(e.full_scale_psi == 60.0);
  CHECK(e.frames == 14);
  CHECK(e.hysteresis_max_fs == Approx(0.2 / 4.5));
  CHECK(e.hysteresis_mean_fs == Approx((0.2 + 0.125) / 4.5 / 4));
  CHECK(e.raw_distance == Approx((0.2 + 0.125) / 4.5 / 4));
  CHECK(e.comp_distance == Approx((3.5 + 2.0) / 60 / 4));
  CHECK(e.comp_distance_of_mean == Approx((3.5 + 1.0) / 60 / 4));
  // The first taxel's four levels are off by 0, 6, 1, 0 psi in the mean of the repeats, the second's by 0, 1, 3, 0.
  CHECK(e.worst_taxel_distance == Approx((6.0 + 1.0) / 60 / 4));
  // Frames: (1 + 5) and (1 + 7) in seven each, and twice (3 + 1).
  check_values({e.taxel_mean_error_psi[0], e.taxel_mean_error_psi[1]}, {1.0, 4.0 / 7.0});
  CHECK(e.worst_taxel == 0);
  CHECK(e.worst_taxel_mean_error_psi == Approx(1.0));
  CHECK(e.mean_error_psi == Approx(11.0 / 14.0));
  CHECK(e.max_error_psi == Approx(7.0));
  // Nothing is flat: what is observable is all.
  CHECK(e.flat_share == 0.0);
  CHECK(e.comp_distance_observable == Approx(e.comp_distance));
  CHECK(e.mean_error_observable_psi == Approx(11.0 / 14.0));
  CHECK(e.max_error_observable_psi == Approx(7.0));
}

TEST_CASE("evaluate: a taxel that is flat everywhere is left out of the observable values only") {
  const Evaluation e = evaluate(known_loop(), noisy_fit());
  CHECK(e.flat_share == Approx(0.5));
  CHECK(e.comp_distance == Approx(5.5 / 60 / 4));
  CHECK(e.comp_distance_observable == Approx(7.0 / 60 / 4));
  CHECK(e.worst_taxel_distance_observable == Approx(7.0 / 60 / 4));
  CHECK(e.mean_error_psi == Approx(11.0 / 14.0));
  CHECK(e.mean_error_observable_psi == Approx(1.0));
  CHECK(e.max_error_observable_psi == Approx(7.0));
  const LevelFigures& forty = e.levels[2];
  CHECK(forty.flat_taxels == 1);
  CHECK(forty.worst_taxel_distance == Approx(3.0 / 60));
  CHECK(forty.worst_taxel_distance_observable == Approx(1.0 / 60));
  CHECK(forty.comp_distance_observable == Approx(1.0 / 60));
  // All weak: nothing is observable, and no figure stands in for it.
  SensorModel weak = noisy_fit();
  weak.taxels[0].noise = 0.06;
  const Evaluation none = evaluate(known_loop(), weak);
  CHECK(none.flat_share == 1.0);
  CHECK(std::isnan(none.comp_distance_observable));
  CHECK(std::isnan(none.mean_error_observable_psi));
  CHECK(none.levels[2].comp_distance_observable == 0.0);
}

TEST_CASE("evaluate: measured, modelled and compensated trace of the mean taxel match hand-computed values") {
  const Evaluation e = evaluate(known_loop(), straight_fit());
  REQUIRE(e.traces.size() == 1);
  const Trace& trace = e.traces.front();
  CHECK(trace.sequence == "loop");
  check_values(trace.pressure_psi, {0, 20, 41, 60, 40, 20, 0});
  check_values(trace.measured_v, {0, 1.5, 3.075, 4.5, 3.125, 1.7, 0});
  check_values(trace.model_v, {0, 1.5, 3.075, 4.5, 3.0, 1.5, 0});  // 4.5 V of 60 psi, without hysteresis
  check_values(trace.compensated_psi, {0, 20, 41, 60, 41, 23.5, 0});
}

TEST_CASE("as found: earlier models are used without the taxels that the run leaves out") {
  const Dataset data = known_loop();
  const SensorModel fit = straight_fit();
  SensorModel before = fit;
  before.taxels[2] = straight_taxel(10.0);  // fitted then, dead now
  const AsFound found = as_found_with(data, fit, before, "earlier");
  CHECK(found.fitted_taxels == 2);
  CHECK(found.evaluation.mean_error_psi == Approx(11.0 / 14.0));
}

TEST_CASE("sweep errors: errors and the zero return match hand-computed values") {
  Dataset data = known_loop();
  data.sequences[0].repeats[0].volts[6 * 3] = 0.004;  // ends 4 mV up, the second repeat 7 mV down
  data.sequences[0].repeats[1].volts[6 * 3] = -0.007;
  const SweepErrors errors = sweep_errors(data, straight_fit());
  CHECK(errors.repeats_with_zero == 2);
  check_values({errors.zero_return_v[0], errors.zero_return_v[1]}, {-0.0015, 0.0});
  check_values({errors.zero_return_s_v[0], errors.zero_return_s_v[1]}, {0.011 / std::sqrt(2.0), 0.0});
  CHECK(errors.groups == 2);
  REQUIRE(errors.levels.size() == 8);
  const LevelReadings& down = errors.levels[5];
  CHECK_FALSE(down.up);
  CHECK(down.pressure_psi == 20.0);
  REQUIRE(down.readings == 2);
  check_values({down.error_psi[0], down.error_psi[1], down.error_psi[3], down.error_psi[4]}, {5, 1, 7, 1});
  CHECK(std::isnan(down.error_psi[2]));
}

// Figures of synthetic arrays.
using namespace synthetic;

namespace {

ArrayOptions small() { return {.rows = 4, .columns = 3}; }

const LevelFigures& level(const Evaluation& evaluation, double pressure) {
  for (const LevelFigures& figures : evaluation.levels)
    if (figures.pressure_psi == pressure) return figures;
  throw std::runtime_error("no such level");
}

}  // namespace

TEST_CASE("evaluate: the result does not depend on the number of threads") {
  const Dataset data = run(Array(small()), {});
  const SensorModel fit = fit_array(data);
  const Evaluation one = evaluate(data, fit, 1), three = evaluate(data, fit, 3);
  CHECK(one.mean_error_psi == three.mean_error_psi);
  CHECK(one.comp_distance == three.comp_distance);
  CHECK(one.taxel_mean_error_psi == three.taxel_mean_error_psi);
}

TEST_CASE("evaluate: hysteresis of the regulator does not count as hysteresis of the sensor") {
  const Array array(small());
  const SensorModel fit = fit_array(run(array, {}));
  const Evaluation straight = evaluate(run(array, {.seed = 5, .regulator_psi = 0.0}), fit);
  // Up and down 1 psi apart: 1.7 % of full pressure.
  const Evaluation lagging = evaluate(run(array, {.seed = 5, .regulator_psi = 0.5}), fit);
  CHECK(level(lagging, 30.0).down_psi - level(lagging, 30.0).up_psi == Approx(1.0).margin(0.05));
  CHECK(std::abs(lagging.comp_distance_of_mean - straight.comp_distance_of_mean) < 0.003);
}

TEST_CASE("evaluate: other sensors, scanners, geometries and origins are refused") {
  const Dataset data = run(Array(small()), {});
  const SensorModel fit = fit_array(data);
  const auto id_of = [&](auto change) {
    Dataset other = data;
    change(other);
    return id_of_refusal([&] { return evaluate(other, fit); });
  };
  CHECK(id_of([](Dataset&) {}).empty());
  CHECK(id_of([](Dataset& d) { d.sensor_serial = "S2"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { d.scanner_serial = "C2"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { std::swap(d.rows, d.columns); }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { d.origin = "hardware"; }) == "TB-ANALYSIS-ORIGIN");
}

// A sensor whose output falls with the pressure: every figure is that of the sensor with its outputs negated.

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

TEST_CASE("falling sensor: errors, hysteresis and permissible errors equal those of a rising sensor") {
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

TEST_CASE("falling sensor: errors and output effect of rates and holds equal those of a rising sensor") {
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

TEST_CASE("falling sensor: creep and temperature effects equal those of a rising sensor") {
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

TEST_CASE("falling sensor: forces under an object are computed as for a rising sensor, volts stay as measured") {
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

TEST_CASE("falling sensor: U of each condition of use equals that of a rising sensor") {
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
