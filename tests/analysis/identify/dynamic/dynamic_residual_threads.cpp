// What a dynamic model says of its own error: against streams of models that did not see a sequence, and the truth.
#include <catch2/catch.hpp>

#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace synthetic;

namespace {

struct ResidualSum {
  double squares = 0.0, samples = 0.0, covered = 0.0;
  [[nodiscard]] double rms() const { return std::sqrt(squares / samples); }
};

// Of sequence `only`, or of all where it is negative.
ResidualSum residual_sum(const Dataset& data, const SensorModel& model, std::size_t taxel, int only) {
  ResidualSum sum;
  const auto stream = compensator_of(model, model.taxels[taxel]);
  stream_samples(
      data, *stream, [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * kTaxels + taxel]; },
      [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        if (only >= 0 && s != static_cast<std::size_t>(only)) return;
        const double error = now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi;
        sum.squares += error * error;
        sum.samples += 1.0;
        sum.covered += std::abs(error) <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
      });
  return sum;
}

Dataset with_one(Dataset data, std::size_t sequence) {
  data.sequences = {data.sequences[sequence]};
  return data;
}

}  // namespace

TEST_CASE("the residual of a dynamic model is that of sequences which its halves did not see", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  const SensorModel down = fit_dynamic(with_one(runs.fitted, 0), runs.rate, runs.creep);
  const SensorModel up = fit_dynamic(with_one(runs.fitted, 1), runs.rate, runs.creep);
  REQUIRE(down.dynamics->shared.creep_share[0] == Approx(model.dynamics->shared.creep_share[0]).epsilon(0.001));
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ResidualSum of_up = residual_sum(runs.fitted, down, t, 1), of_down = residual_sum(runs.fitted, up, t, 0);
    const double held_out = std::sqrt((of_up.squares + of_down.squares) / (of_up.samples + of_down.samples));
    const double twice_own = 2.0 * residual_sum(runs.fitted, model, t, -1).rms();
    INFO("taxel " << t << ": twice what its own stream leaves is " << twice_own);
    // Models of one sequence alone begin at rest, where the model's halves have what went before.
    CHECK(model.taxels[t].residual_psi == Approx(held_out).epsilon(0.35));
    CHECK(model.taxels[t].residual_psi > 1.5 * twice_own);
  }
}

TEST_CASE("without a sequence to hold out the residual is twice what the fitted data leave", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  Dataset one_name = runs.fitted, one_narrow = runs.fitted;
  one_name.sequences[1].name = one_name.sequences[0].name;
  one_narrow.sequences[1] = runs.other.sequences[0];
  for (Sample& sample : one_narrow.sequences[1].repeats[0].steps) sample.setpoint_psi *= 0.9;  // never at 60 psi
  for (const Dataset& fitted : {with_one(runs.fitted, 0), one_name, one_narrow}) {
    const SensorModel model = fit_dynamic(fitted, runs.rate, runs.creep);
    for (std::size_t t = 0; t < kTaxels; ++t)
      CHECK(model.taxels[t].residual_psi == Approx(2.0 * residual_sum(fitted, model, t, -1).rms()).epsilon(1e-6));
  }
}

TEST_CASE("twice the uncertainty of a dynamic model holds most pressures on a path of its own", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  ResidualSum all;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ResidualSum own = residual_sum(runs.other, model, t, -1);
    all.samples += own.samples;
    all.covered += own.covered;
    all.squares += own.squares;
    // Not by being wide: the residual is no more than a few times the error that is there.
    CHECK(model.taxels[t].residual_psi < 5.0 * own.rms());
  }
  INFO(100.0 * all.covered / all.samples << " % of " << all.samples << " samples, which err by " << all.rms()
                                         << " psi");
  CHECK(all.covered > 0.9 * all.samples);
}
