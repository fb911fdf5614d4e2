// Figures of synthetic arrays; those with an answer known on paper are in evaluation_answers.cpp.
#include "analysis/statistics/figures/evaluation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "analysis/statistics/conformity/verdict.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

ArrayOptions small() {
  ArrayOptions options;
  options.rows = 4;
  options.columns = 3;
  return options;
}

const LevelFigures& level(const Evaluation& evaluation, double pressure) {
  for (const LevelFigures& figures : evaluation.levels)
    if (figures.pressure_psi == pressure) return figures;
  throw std::runtime_error("no such level");
}

}  // namespace

TEST_CASE("figures of a small array, recomputed by hand") {
  const Array array(small());
  const Dataset data = run(array, {});
  const SensorModel fit = fit_array(data);
  RunOptions again;
  again.seed = 2;
  again.repeats = 1;
  again.regulator_psi = 0.0;
  again.reference_noise_psi = 0.0;
  const Dataset held = run(array, again);
  const Evaluation e = evaluate(held, fit);
  CHECK(e.run == 2);
  CHECK(e.model_run == 1);
  CHECK(e.frames == 211 + 451);
  CHECK(e.levels.size() == 31);
  CHECK(e.full_scale_psi == 60.0);
  CHECK(e.excluded_taxels == 0);

  // Full sweeps: one in the descending sequence, five in the other.
  const auto sweeps = [&](bool ascending, double pressure) {
    std::vector<double> sum(12, 0.0);
    int count = 0;
    for (const SequenceData& sequence : held.sequences) {
      const Repeat& repeat = sequence.repeats[0];
      std::vector<double> levels;
      for (const Sample& step : repeat.steps) levels.push_back(step.setpoint_psi);
      for (const Branch& branch : branches_along(levels)) {
        if (branch.ascending != ascending || branch.last - branch.first != 30) continue;
        ++count;
        for (int i = branch.first; i <= branch.last; ++i)
          if (repeat.steps[static_cast<std::size_t>(i)].setpoint_psi == pressure)
            for (std::size_t taxel = 0; taxel < 12; ++taxel)
              sum[taxel] += repeat.volts[static_cast<std::size_t>(i) * 12 + taxel];
      }
    }
    REQUIRE(count == 6);
    for (double& value : sum) value /= count;
    return sum;
  };
  const auto up = sweeps(true, 20.0), down = sweeps(false, 20.0);
  const LevelFigures& twenty = level(e, 20.0);
  double mean_up = 0.0, mean_down = 0.0, distance = 0.0;
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK(twenty.raw_up_v[i] == Approx(up[i]));
    CHECK(twenty.raw_down_v[i] == Approx(down[i]));
    mean_up += up[i] / 12;
    mean_down += down[i] / 12;
    distance += std::abs(up[i] - down[i]) / 12;
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < 12; ++i) squares += (up[i] - mean_up) * (up[i] - mean_up);
  CHECK(twenty.raw_std_up == Approx(std::sqrt(squares / 11) / e.full_scale_v));
  CHECK(twenty.raw_distance == Approx(distance / e.full_scale_v));
  CHECK(twenty.raw_mean_distance == Approx(std::abs(mean_up - mean_down) / e.full_scale_v));

  double mean = 0.0, largest = 0.0, compensated = 0.0;
  for (const LevelFigures& figures : e.levels) {
    mean += figures.raw_mean_distance / 31;
    largest = std::max(largest, figures.raw_mean_distance);
    double u = 0.0, d = 0.0;
    for (std::size_t i = 0; i < 12; ++i) {
      u += figures.comp_up_psi[i] / 12;
      d += figures.comp_down_psi[i] / 12;
    }
    compensated += std::abs(u - d) / 60.0 / 31;
    CHECK(figures.comp_distance_observable <= figures.worst_taxel_distance_observable + 1e-15);
    CHECK(figures.worst_taxel_distance_observable <= figures.worst_taxel_distance);
  }
  CHECK(e.raw_distance == Approx(mean));
  CHECK(e.hysteresis_max_fs == Approx(largest));
  CHECK(e.comp_distance_of_mean == Approx(compensated));
  CHECK(e.comp_distance_of_mean < 0.015);
  CHECK(e.raw_distance > 0.08);
  CHECK(e.worst_taxel_mean_error_psi == e.taxel_mean_error_psi[static_cast<std::size_t>(e.worst_taxel)]);

  REQUIRE(e.traces.size() == 2);
  CHECK(e.traces[0].pressure_psi.size() == 211);
  CHECK(e.traces[1].model_v.size() == 451);
  for (std::size_t i = 0; i < 211; ++i)
    CHECK(e.traces[0].model_v[i] == Approx(e.traces[0].measured_v[i]).margin(0.04 * e.full_scale_v));
}

TEST_CASE("figures do not depend on the number of threads") {
  const Dataset data = run(Array(small()), {});
  const SensorModel fit = fit_array(data);
  const Evaluation one = evaluate(data, fit, 1), three = evaluate(data, fit, 3);
  CHECK(one.mean_error_psi == three.mean_error_psi);
  CHECK(one.comp_distance == three.comp_distance);
  CHECK(one.taxel_mean_error_psi == three.taxel_mean_error_psi);
}

TEST_CASE("the regulator's own hysteresis is not counted as the sensor's") {
  const Array array(small());
  const SensorModel fit = fit_array(run(array, {}));
  RunOptions options;
  options.seed = 5;
  options.regulator_psi = 0.0;
  const Evaluation straight = evaluate(run(array, options), fit);
  options.regulator_psi = 0.5;  // up and down 1 psi apart: 1.7 % of full pressure
  const Evaluation lagging = evaluate(run(array, options), fit);
  CHECK(level(lagging, 30.0).down_psi - level(lagging, 30.0).up_psi == Approx(1.0).margin(0.05));
  CHECK(std::abs(lagging.comp_distance_of_mean - straight.comp_distance_of_mean) < 0.003);
}

TEST_CASE("taxels that are not fitted are left out and counted") {
  const Array array(small());
  Dataset data = run(array, {});
  for (SequenceData& sequence : data.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) repeat.volts[i * 12 + 5] = 0.0;
  const SensorModel fit = fit_array(data);
  const Evaluation e = evaluate(data, fit);
  CHECK(e.excluded_taxels == 1);
  CHECK(std::isnan(e.taxel_mean_error_psi[5]));
  CHECK(std::isnan(level(e, 30.0).comp_up_psi[5]));
  CHECK(level(e, 30.0).raw_up_v[5] == 0.0);
  CHECK(level(e, 30.0).raw_std_up < 0.3);  // the dead one would widen it
  CHECK(std::isfinite(e.comp_distance));
}

TEST_CASE("other sensors, scanners, geometries and origins are refused") {
  const Dataset data = run(Array(small()), {});
  const SensorModel fit = fit_array(data);
  const auto id_of = [&](auto change) {
    Dataset other = data;
    change(other);
    try {
      evaluate(other, fit);
    } catch (const AnalysisError& error) {
      return error.id();
    }
    return std::string("accepted");
  };
  CHECK(id_of([](Dataset&) {}) == "accepted");
  CHECK(id_of([](Dataset& d) { d.sensor_serial = "S2"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { d.scanner_serial = "C2"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { std::swap(d.rows, d.columns); }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(id_of([](Dataset& d) { d.origin = "hardware"; }) == "TB-ANALYSIS-ORIGIN");
}

TEST_CASE("limits are judged by the simple rule: equality passes, nothing measured is inconclusive") {
  Evaluation e;
  e.run = 7;
  e.frames = 1;
  e.worst_taxel = 0;
  e.mean_error_psi = 1.0;
  e.worst_taxel_mean_error_psi = 2.5;
  e.comp_distance_of_mean = std::numeric_limits<double>::quiet_NaN();
  LevelFigures forty;
  forty.pressure_psi = 40.0;
  forty.comp_std_up = 0.03;
  forty.comp_std_down = 0.05;
  e.levels.push_back(forty);
  SensorModel fit;
  fit.taxels.resize(3);
  fit.taxels[0].status = fit.taxels[2].status = TaxelStatus::kFitted;
  Limits limits;
  limits.mean_compensation_error_psi = 1.0;
  limits.worst_taxel_error_psi = 2.0;
  limits.distance_of_mean_fs = 0.015;
  limits.unfit_taxels = 1;
  limits.mismatch = {{40.0, 0.04}, {41.0, 0.04}};
  limits.sha256 = "abc";
  const auto verdicts = judge(e, fit, limits);
  REQUIRE(verdicts.size() == 8);
  const auto word = [&](std::size_t i) {
    return verdicts[i].criterion + ", " + verdicts[i].scope + ": " + verdicts[i].verdict;
  };
  CHECK(word(0) == "mean_compensation_error, array: pass");
  CHECK(word(1) == "worst_taxel_error, array: fail");
  CHECK(word(2) == "distance_of_mean, array: inconclusive");
  CHECK(word(3) == "unfit_taxels, array: pass");
  CHECK(word(4) == "mismatch, 40 psi up: pass");
  CHECK(word(5) == "mismatch, 40 psi down: fail");
  CHECK(word(6) == "mismatch, 41 psi up: inconclusive");
  CHECK(word(7) == "mismatch, 41 psi down: inconclusive");
  CHECK(verdicts[5].value == 0.05);
  CHECK(verdicts[5].limit == 0.04);
  CHECK(verdicts[0].run == 7);
  CHECK(verdicts[0].rule == "simple");
  CHECK(verdicts[0].limits_sha256 == "abc");
}
