#include <catch2/catch.hpp>

#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset short_run() {
  ArrayOptions options;
  options.rows = 1;
  options.columns = 2;
  Dataset dataset = run(Array(options), {});
  dataset.sensor_serial = "A";
  dataset.scanner_serial = "S1";
  dataset.temperatures_c = {21.0, 22.5};
  for (SequenceData& sequence : dataset.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        repeat.steps[i].time_s = 3.0 * static_cast<double>(i);
        repeat.steps[i].held_s = 2.0;
      }
  return dataset;
}

std::vector<std::string> outside(const SensorModel& model, const Dataset& used) {
  return outside_validity(model, histories_of(used));
}

}  // namespace

TEST_CASE("the validity box contains the fitted data and names each way in which a use lies outside") {
  const Dataset fitted = short_run();
  const SensorModel model = fit_models("monotone", histories_of(fitted), {}, {});
  REQUIRE(model.validity.temperature_c);
  CHECK(model.validity.temperature_c->high == 22.5);
  CHECK(outside(model, fitted).empty());

  Dataset other = short_run();
  other.sensor_serial = "B";
  other.scanner_serial = "S2";
  other.temperatures_c = {30.0};
  for (SequenceData& sequence : other.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& step : repeat.steps) {
        step.time_s /= 4.0;
        step.held_s = 0.5;
        step.reference_psi *= 1.1;
      }
  CHECK(outside(model, other).size() == 6);  // sensor, scanner, input, hold, rate, temperature
}

TEST_CASE("a use slightly beyond the box, slower, or unknown is not reported as outside") {
  const SensorModel model = fit_models("monotone", histories_of(short_run()), {}, {});
  Dataset other = short_run();
  other.sensor_serial.clear();
  other.temperatures_c = {23.4};
  for (SequenceData& sequence : other.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& step : repeat.steps) {
        step.time_s *= 4.0;
        step.held_s = 2.1;
        step.reference_psi *= 1.01;
      }
  CHECK(outside(model, other).empty());
  other.temperatures_c.clear();
  CHECK(outside(model, other).empty());
}
