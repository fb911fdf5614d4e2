// Streams of single-valued models by hand: what frames say of each taxel, what is left over.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "analysis/compensate/document.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/monotone.h"
#include "tests/analysis/identify/refusals.h"

using namespace tactbench::analysis;

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
  CHECK(out.status[0] == kTaxelOutside);
  CHECK(out.status[1] == kTaxelOutside);
  CHECK(out.status[2] == kTaxelDead);
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
