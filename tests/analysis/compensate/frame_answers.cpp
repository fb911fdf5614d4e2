// The frame compensator's uncertainty by hand: that of a piece is of the end that is observed less well.
#include <catch2/catch.hpp>
#include <vector>

#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

namespace {

FrameSetup one_taxel(const std::vector<double>& up, const std::vector<double>& down, double noise_v) {
  FrameSetup setup;
  for (std::size_t i = 0; i < up.size(); ++i) setup.pressure_psi.push_back(20.0 * static_cast<double>(i));
  setup.taxels.push_back({true, up, down, {}, noise_v, false});
  setup.volts_per_count = 1e-9;
  setup.elam.exact_outer = true;
  setup.start_unknown = false;
  setup.options.drift_share = 0.0;
  return setup;
}

template <class Real>
double last_uncertainty(FrameCompensator<Real>& frames, const std::vector<double>& volts, double pressure) {
  Results<Real> results(1);
  for (const double v : volts) {
    const Real one[] = {static_cast<Real>(v)};
    frames.frame(std::span<const Real>(one), results.output());
  }
  CHECK(static_cast<double>(results.pressure[0]) == Approx(pressure));
  return static_cast<double>(results.uncertainty[0]);
}

}  // namespace

TEMPLATE_TEST_CASE("frames by hand: noise times the flatter end's psi a volt, going up and coming down", "", float,
                   double) {
  // 40, 20 and 10 psi a volt, and the other way round.
  const std::vector<double> steeper{0.0, 0.5, 1.5, 3.5}, flatter{0.0, 2.0, 3.0, 3.5};
  const auto rising = [](const std::vector<double>& up, double y, double x) {
    FrameCompensator<TestType> frames(one_taxel(up, up, 0.001));
    return last_uncertainty(frames, {y}, x);
  };
  // The split of the rise lies at 1.75 V, halfway up: it ends a piece as well.
  CHECK(rising(steeper, 1.0, 30.0) == Approx(0.04).epsilon(1e-4));  // at 20 psi that is what lies behind
  CHECK(rising(steeper, 2.5, 50.0) == Approx(0.01).epsilon(1e-4));
  CHECK(rising(steeper, 0.25, 10.0) == Approx(0.04).epsilon(1e-4));
  CHECK(rising(flatter, 2.5, 30.0) == Approx(0.04).epsilon(1e-4));  // at 40 psi, 40 a volt ahead
  CHECK(rising(flatter, 1.0, 10.0) == Approx(0.01).epsilon(1e-4));
  CHECK(rising(flatter, 3.25, 50.0) == Approx(0.04).epsilon(1e-4));
  const auto falling = [](const std::vector<double>& down, double y, double x) {
    FrameCompensator<TestType> frames(one_taxel(down, down, 0.001));
    return last_uncertainty(frames, {3.5, y, y - 0.02}, x);
  };
  // The split of the fall lies at 30 psi.
  CHECK(falling(steeper, 0.92, 28.0) == Approx(0.04).epsilon(1e-4));
  CHECK(falling(steeper, 1.22, 34.0) == Approx(0.02).epsilon(1e-4));
  CHECK(falling(flatter, 2.62, 32.0) == Approx(0.04).epsilon(1e-4));
  CHECK(falling(flatter, 1.02, 10.0) == Approx(0.02).epsilon(1e-4));
}
