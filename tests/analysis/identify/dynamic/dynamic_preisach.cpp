// Streams of a dynamic Preisach model on films of known truth, simulated by other means.
#include <catch2/catch.hpp>

#include "analysis/compensate/compensator.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

std::unique_ptr<Compensator> stream_of(const HysteresisModel& model, const Dynamics& dynamics,
                                       const DynamicTaxel& taxel) {
  CompensatorSetup setup;
  setup.time = std::make_shared<PassedTime>();
  setup.time->dynamics = dynamics;
  setup.creep_scale = taxel.creep_scale;
  setup.lag_share = taxel.lag_share;
  return make_compensator(model, setup);
}

}  // namespace

TEST_CASE("a stream gives a creeping film's pressures back behind its divider", "[dynamic]") {
  const DynamicArray array = dynamic_array(4);
  for (std::size_t t = 0; t < array.films.size(); ++t) {
    const LinearisedModel model(array.taxels[t].divider, std::make_shared<PreisachModel>(array.films[t]));
    DynamicPlant plant(array.films[t], array.dynamics, array.taxels[t]);
    const auto stream = stream_of(model, array.dynamics, array.taxels[t]);
    const auto deaf = stream_of(model, {}, {});
    double sum = 0.0, most = 0.0, deaf_sum = 0.0;
    const std::vector<double> way = random_way(600, 2.0, static_cast<unsigned>(t) + 9);
    for (const double psi : way) {
      const double seconds = psi == 0.0 ? 30.0 : 2.5, volts = plant.step(psi, seconds);
      const double error = std::abs(stream->step(volts, seconds).pressure_psi - psi);
      deaf_sum += std::abs(deaf->step(volts, 0.0).pressure_psi - psi);
      sum += error;
      most = std::max(most, error);
    }
    const auto count = static_cast<double>(way.size());
    INFO("taxel " << t << ": " << sum / count << " psi, most " << most << ", without time " << deaf_sum / count);
    CHECK(sum / count < 0.03);
    CHECK(most < 0.6);
    CHECK(deaf_sum > 5.0 * sum);
  }
}

TEST_CASE("beyond a nearly level piece of a branch the creep's target is not guessed along its slope", "[dynamic]") {
  const PreisachModel film(0.0, 60.0, 0.0, {2.0, 0.0, 0.01, 0.0, 0.0, 2.0});  // 10 mV from 20 to 40 psi
  DynamicArray array = dynamic_array(1);
  array.dynamics.creep_share = {0.3, 0.0, 0.0};
  DynamicPlant plant(film, array.dynamics, array.taxels[0]);
  const LinearisedModel model(array.taxels[0].divider, std::make_shared<PreisachModel>(film));
  const auto stream = stream_of(model, array.dynamics, array.taxels[0]);
  double most = 0.0;
  for (int i = 0; i <= 60; ++i) {
    const double psi = i <= 30 ? 2.0 * i : 120.0 - 2.0 * i;
    const double off = std::abs(stream->step(plant.step(psi, 2.5), 2.5).pressure_psi - psi);
    if (psi < 20.0 || psi > 40.0) most = std::max(most, off);
  }
  CHECK(most < 1.0);
}
