// Figures of synthetic arrays; those with an answer known on paper are in evaluation_answers_threads.cpp.
#include "analysis/statistics/figures/evaluation.h"

#include <catch2/catch.hpp>
#include <cmath>

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
