// Temperature in the budget: coefficients by hand from runs made by formula, and what keeps them from being assessed.
#include "analysis/statistics/temperature_effect.h"

#include <catch2/catch.hpp>

#include "analysis/compensate/compensator.h"
#include "analysis/error.h"
#include "tests/analysis/support/effect_runs.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace effect_runs;

namespace {

constexpr double kStepC = 0.1;

TemperatureEffect effect_of(const Example& example, const std::vector<Dataset>& others, double own_share = 0.0) {
  return temperature_effect_of(at_temperature(example, 23.0, 0.0, 0.0, own_share), others, example.fit, kStepC);
}

}  // namespace

TEST_CASE("the coefficient is the change of output and zero a kelvin, and the width covers the run's temperatures") {
  const Example example;
  const TemperatureEffect effect = effect_of(example, {at_temperature(example, 28.0, -0.01, 0.02)});
  REQUIRE(effect.assessed());
  REQUIRE(effect.temperature_c.size() == 2);
  CHECK(effect.temperature_c[0] == Approx(23.0));
  CHECK(effect.temperature_c[1] == Approx(28.0));
  CHECK(effect.per_kelvin.share == Approx(-0.002).epsilon(1e-3));
  CHECK(effect.per_kelvin.zero_v == Approx(0.004).epsilon(2e-2));
  CHECK(effect.half_width_c() == Approx(0.5 * (0.2 + kStepC)));
  CHECK(effect.deviation.share < 1e-4);
  CHECK(effect.from_repeats);
  CHECK(effect.dof == 4.0);  // three repeats each
  const double coefficient = effect.per_kelvin.zero_v + 2.0 * effect.per_kelvin.share;
  CHECK(effect.width_v(2.0) ==
        Approx(0.15 * std::sqrt(coefficient * coefficient + std::pow(effect.u.zero_v, 2) +
                                std::pow(effect.deviation.zero_v, 2) + 4.0 * std::pow(effect.u.share, 2) +
                                4.0 * std::pow(effect.deviation.share, 2))));
  CHECK_THAT(effect.in_words(), Catch::Contains("2 runs at 23.0 to 28.0 °C") && Catch::Contains("(-0.2000 ±") &&
                                    Catch::Contains("22.90 to 23.10 °C") && Catch::Contains("is contained"));
}

TEST_CASE("the coefficient's own uncertainty is the repeats' scatter over the kelvins between two runs") {
  const Example example(0.0);
  constexpr double kRepeat = 0.004;
  // Repeats at 0, +r and -r: standard deviation r about their mean, in both runs; r sqrt(1/3 + 1/3) / 5 K. What the
  // synthetic repeats differ by anyway (their pressures) is found without r.
  const double before = effect_of(example, {at_temperature(example, 28.0, -0.01, 0.0)}).u.share;
  const TemperatureEffect effect = effect_of(example, {at_temperature(example, 28.0, -0.01, 0.0, kRepeat)}, kRepeat);
  CHECK(before < 2e-5);
  CHECK(effect.u.share == Approx(kRepeat * std::sqrt(2.0 / 3.0) / 5.0).epsilon(0.05));
  CHECK(effect.per_kelvin.share == Approx(-0.002).epsilon(0.01));

  // Three runs off a line by e, -2 e, e: residual standard deviation sqrt(6) e with one degree of freedom, over the
  // root of the temperatures' squares about their mean.
  constexpr double kOff = 0.003;
  const TemperatureEffect bent = effect_of(
      example, {at_temperature(example, 28.0, -0.01 - 3.0 * kOff, 0.0), at_temperature(example, 33.0, -0.02, 0.0)});
  CHECK_FALSE(bent.from_repeats);
  CHECK(bent.dof == 1.0);
  CHECK(bent.per_kelvin.share == Approx(-0.002).epsilon(0.01));
  CHECK(bent.u.share == Approx(std::sqrt(6.0) * kOff / std::sqrt(50.0)).epsilon(0.02));
  CHECK_THAT(bent.in_words(), Catch::Contains("scatter of the runs about the line"));
}

TEST_CASE("temperature is not assessed from other sensors, one temperature, no readings, or single repeats") {
  const Example example;
  Dataset other = at_temperature(example, 28.0, -0.01, 0.0);
  other.sensor_serial = "S2";
  CHECK_THROWS_AS(effect_of(example, {other}), AnalysisError);

  CHECK_THAT(effect_of(example, {}).not_assessed, Catch::Contains("another temperature"));
  CHECK_THAT(effect_of(example, {at_temperature(example, 24.9, -0.01, 0.0)}).not_assessed,
             Catch::Contains("at one temperature: 23.0 to 24.9"));
  CHECK(effect_of(example, {at_temperature(example, 25.0, -0.01, 0.0)}).assessed());
  Dataset silent = at_temperature(example, 28.0, -0.01, 0.0);
  silent.temperatures_c.clear();
  CHECK_THAT(effect_of(example, {silent}).not_assessed, Catch::Contains("have no temperature readings"));
  CHECK(effect_of(example, {silent}).in_words().empty());
  CHECK_FALSE(at_another_temperature(example.dataset.temperatures_c, silent.temperatures_c));
  const Dataset warm = at_temperature(example, 28.0, -0.01, 0.0);
  CHECK_THAT(temperature_effect_of(example.dataset, std::vector<Dataset>{warm}, example.fit, kStepC).not_assessed,
             Catch::Contains("the run has no temperature readings"));

  Dataset calibration = at_temperature(example, 23.0, 0.0, 0.0), single = warm;
  for (Dataset* run : {&calibration, &single})
    for (SequenceData& data : run->sequences) data.repeats.resize(1);
  CHECK_THAT(temperature_effect_of(calibration, std::vector<Dataset>{single}, example.fit, kStepC).not_assessed,
             Catch::Contains("one repeat each"));
  // A run that holds its levels is no loop to compare with.
  Dataset held = hold_run(example, {});
  held.temperatures_c = {28.0};
  CHECK_THAT(effect_of(example, {held}).not_assessed, Catch::Contains("five levels"));
}

TEST_CASE("temperature enters the budget as volts of a rectangle, along the whole loop") {
  const Example example;
  Dataset calibration = at_temperature(example, 23.0, 0.0, 0.0);
  calibration.temperatures_c = {21.0, 25.0};
  UncertaintyInputs inputs;
  inputs.temperature = temperature_effect_of(
      calibration, std::vector<Dataset>{at_temperature(example, 28.0, -0.01, 0.0)}, example.fit, kStepC);
  REQUIRE(inputs.temperature.assessed());
  const Uncertainty with = assess_uncertainty(calibration, example.fit, record_with_reference(""), inputs);
  CHECK_THAT(with.from[static_cast<std::size_t>(UncertaintySource::kTemperature)], Catch::Contains("°C"));
  for (const bool up : {true, false}) {
    const Budget& budget = with.level(40.0, up)->worst;
    const Contribution* row = row_of(budget, UncertaintySource::kTemperature);
    REQUIRE(row != nullptr);
    const auto taxel = static_cast<std::size_t>(budget.taxel);
    const ElamModel& model = example.fit.taxels[taxel].fit.model;
    const ElamCurve rising(model, true, model.x0(), model.y0()), falling(model, false, model.xu(), model.yu());
    const double v = (up ? rising : falling).output(40.0);
    CHECK(row->width == Approx(inputs.temperature.width_v(v - model.y0())));
    CHECK(row->divisor == Approx(std::sqrt(3.0)));
    CHECK(row->u_psi == Approx(row->width / std::sqrt(3.0) * std::abs(row->sensitivity)));
    // What the compensator makes of a loop that is warm or cold throughout.
    const auto read = [&](double sign) {
      TaxelCompensator compensator(model, {});
      double estimate = 0.0;
      const auto step_at = [&](const ElamCurve& curve, int level) {
        const double clean = curve.output(level);
        estimate = compensator.step(clean + sign * inputs.temperature.width_v(clean - model.y0())).pressure_psi;
      };
      for (int level = 2; level <= (up ? 40 : 60); level += 2) step_at(rising, level);
      for (int level = 58; level >= 40 && !up; level -= 2) step_at(falling, level);
      return estimate;
    };
    CHECK(row->sensitivity * row->width == Approx(0.5 * (read(1.0) - read(-1.0))).epsilon(0.05));
  }
}
