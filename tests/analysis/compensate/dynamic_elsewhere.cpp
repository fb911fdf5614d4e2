// A dynamic compensator whose pressures do not begin at 0: each is as much higher, whatever is undone.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

constexpr double kLowestPsi = 14.0;

DynamicSetup range_from(double x_low, bool unknown) {
  DynamicSetup setup = dynamic_array(1, 0.002, 8).setup;
  setup.x_low = x_low;
  setup.x_high = x_low + 60.0;
  setup.worked_s = 25.0;
  setup.start_unknown = unknown;
  setup.residual_psi.assign(16, 0.2);
  return setup;
}

std::vector<double> volts_of_way() {
  DynamicArray array = dynamic_array(1, 0.002, 8);
  DynamicPlant plant(array.films[0], array.setup.dynamics, array.setup.taxels[0], 20);
  std::vector<double> volts;
  for (const double psi : {5.0, 20.0, 20.0, 45.0, 59.0, 30.0, 30.0, 50.0, 12.0, 12.0, 3.0, 55.0})
    volts.push_back(plant.step(psi, 2.0));
  return volts;
}

}  // namespace

TEST_CASE("dynamic: a range from 14 psi on gives the pressures of one from 0 on, and 14 psi more", "[dynamic]") {
  for (const bool unknown : {false, true}) {
    const DynamicSetup from_zero = range_from(0.0, unknown), higher = range_from(kLowestPsi, unknown);
    DynamicTaxelCompensator zero(from_zero, 0), other(higher, 0);
    DynamicFrameCompensator<double> zero_frames(from_zero), other_frames(higher);
    zero_frames.set_interval(2.0);
    other_frames.set_interval(2.0);
    if (unknown) zero.reset_unknown();
    if (unknown) other.reset_unknown();
    const auto go = [&](bool frames_too) {
      for (const double volts : volts_of_way()) {
        const Compensated a = zero.step(volts, 2.0), b = other.step(volts, 2.0);
        CHECK(b.pressure_psi == Approx(a.pressure_psi + kLowestPsi).margin(1e-9));
        CHECK(b.uncertainty_psi == Approx(a.uncertainty_psi));
        CHECK((b.unknown == a.unknown && b.flat == a.flat && b.out_of_range == a.out_of_range));
        if (!frames_too) continue;
        const std::vector<double> one{volts};
        std::vector<double> pressure(1), higher_pressure(1), uncertainty(1), higher_uncertainty(1);
        std::vector<std::uint16_t> status(1), higher_status(1);
        zero_frames.frame(std::span<const double>(one), {pressure, uncertainty, status});
        other_frames.frame(std::span<const double>(one), {higher_pressure, higher_uncertainty, higher_status});
        CHECK(higher_pressure[0] == Approx(pressure[0] + kLowestPsi).margin(1e-9));
        CHECK(higher_uncertainty[0] == Approx(uncertainty[0]));
        CHECK(higher_status == status);
      }
    };
    go(true);
    zero.work(40.0);
    other.work(40.0);
    go(false);
    zero.rest(15.0);
    other.rest(15.0);
    go(false);
    zero.reset();
    other.reset();
    zero_frames.reset();
    other_frames.reset();
    go(true);
  }
}
