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
