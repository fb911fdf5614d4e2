// A regulator's own hysteresis is not the sensor's.
#include <catch2/catch.hpp>

#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

// Outputs are moved to the set-point by the measured reference.
TEST_CASE("a regulator with 0.5 % of hysteresis leaves the fit as it is") {
  ArrayOptions options;
  options.rows = 2;
  options.columns = 4;
  options.sensor_seed = 31;
  options.play_share = 0.0;
  const Array array(options);
  RunOptions without, with;
  without.regulator_psi = 0.0;
  with.regulator_psi = 0.3;          // short of the set-point by it on every way up and on every way down
  Dataset blind = run(array, with);  // as if nobody had measured where the pressure was
  for (SequenceData& sequence : blind.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (Sample& sample : repeat.steps) sample.reference_psi = sample.setpoint_psi;
  const SensorModel still = fit_array(run(array, without)), moved = fit_array(run(array, with)), off = fit_array(blind);
  const auto loop_error = [&](const SensorModel& fit, std::size_t i) {
    const ModelTaxel &model = fit.taxels[i], &own = still.taxels[i];
    double most = 0.0;
    for (int x = 0; x <= 60; x += 2)
      most = std::max(
          {most, std::abs(model.ascending(x) - own.ascending(x)), std::abs(model.descending(x) - own.descending(x))});
    return most / own.yu();
  };
  for (std::size_t i = 0; i < still.array().size(); ++i) {
    const ModelTaxel &first = still.taxels[i], &second = moved.taxels[i];
    const ModelFit &a = first.fit, &b = second.fit;
    const ElamParameters &p = elam_of(first)->parameters, &q = elam_of(second)->parameters;
    INFO("taxel " << i << ": J " << a.j << " and " << b.j << ", loops " << loop_error(moved, i) << " and "
                  << loop_error(off, i) << " apart");
    CHECK(loop_error(moved, i) < 0.002);
    CHECK(loop_error(off, i) > 0.006);
    CHECK(std::abs(b.mean_error / second.full_scale() - a.mean_error / first.full_scale()) < 2e-4);
    CHECK(std::abs(b.j - a.j) < 660 * std::pow(0.002 * first.full_scale(), 2));  // 0.2 % a sample
    CHECK(std::abs(q.alpha_d - p.alpha_d) < 0.01);
    CHECK(std::abs(q.beta_d - p.beta_d) < 0.002);
    CHECK(std::abs(q.alpha_a0 - p.alpha_a0) < 0.05);
    CHECK(std::abs(q.alpha_a0 + 60 * q.alpha_a1 - p.alpha_a0 - 60 * p.alpha_a1) < 0.04);
    CHECK(std::abs(q.beta_a - p.beta_a) < 0.05);
  }
}
