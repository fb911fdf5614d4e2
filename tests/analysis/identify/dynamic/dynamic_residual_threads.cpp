// What a dynamic model says of its own error, against the truth.
#include <catch2/catch.hpp>

#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace synthetic;

namespace {

struct ResidualSum {
  double squares = 0.0, samples = 0.0, covered = 0.0;
  [[nodiscard]] double rms() const { return std::sqrt(squares / samples); }
};

ResidualSum residual_sum(const Dataset& data, const SensorModel& model, std::size_t taxel) {
  ResidualSum sum;
  const auto stream = compensator_of(model, model.taxels[taxel]);
  stream_samples(
      data, *stream, [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * kTaxels + taxel]; },
      [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
        const double error = now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi;
        sum.squares += error * error;
        sum.samples += 1.0;
        sum.covered += std::abs(error) <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
      });
  return sum;
}

}  // namespace

TEST_CASE("the residual of a dynamic model is that of ways that it was not fitted to", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  // Two inner branches, which 120 weights follow wherever they go; many; and none.
  const std::vector<double> few = way_along({0, 60, 0, 40, 0, 60, 20, 60, 0}, 4.0);
  const Dataset loops = run_of(array, {{"loops", {{way_along({0, 60, 0}, 4.0)}}}}, 5);
  for (const Dataset& fitted : {run_of(array, {{"few", {{few}}}}, 1), runs.fitted, loops}) {
    const SensorModel model = fit_dynamic_alone(fitted);
    ResidualSum seen, other;
    double stated2 = 0.0;
    for (std::size_t t = 0; t < kTaxels; ++t) {
      for (auto [sum, data] : {std::pair{&seen, &fitted}, {&other, &runs.other}}) {
        const ResidualSum own = residual_sum(*data, model, t);
        sum->squares += own.squares;
        sum->samples += own.samples;
        sum->covered += own.covered;
      }
      stated2 += model.taxels[t].residual_psi * model.taxels[t].residual_psi / kTaxels;
    }
    INFO(fitted.sequences.front().name << ": stated " << std::sqrt(stated2) << ", fitted leave " << seen.rms()
                                       << ", others " << other.rms() << ", of which "
                                       << 100.0 * other.covered / other.samples << " % within");
    CHECK(std::sqrt(stated2) > 0.5 * other.rms());
    CHECK(std::sqrt(stated2) < 4.0 * other.rms());
    CHECK(other.covered > 0.85 * other.samples);
  }
}

TEST_CASE("twice the uncertainty of a dynamic model holds most pressures on a path of its own", "[dynamic]") {
  const DynamicArray array = dynamic_array(kTaxels);
  const Runs runs = runs_of(array);
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep);
  ResidualSum all;
  for (std::size_t t = 0; t < kTaxels; ++t) {
    const ResidualSum own = residual_sum(runs.other, model, t);
    all.samples += own.samples;
    all.covered += own.covered;
    all.squares += own.squares;
    // Not by being wide: the residual is no more than a few times the error that is there.
    CHECK(model.taxels[t].residual_psi < 6.0 * own.rms());
  }
  INFO(100.0 * all.covered / all.samples << " % of " << all.samples << " samples, which err by " << all.rms()
                                         << " psi");
  CHECK(all.covered > 0.9 * all.samples);
}
