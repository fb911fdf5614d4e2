// Outputs that lie exactly on an end of a dynamic model's range, or of its divider.
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "analysis/compensate/dynamic_setup.h"
#include "tests/analysis/compensate/straight_setup.h"

using namespace tactbench::analysis;

TEST_CASE("exact ends: a dynamic model's range includes both of its ends, with and without noise", "[dynamic]") {
  for (const double noise : {0.0, 0.0625}) {
    const DynamicSetup setup = straight_setup(noise);
    DynamicTaxelCompensator compensator(setup, 0);
    const double band = 5.5 * noise;
    for (const auto& [output, out] :
         {std::pair{6.0 + band, false}, {6.0 + band + 1e-9, true}, {-band, false}, {-band - 1e-9, true}}) {
      CAPTURE(noise, output);
      compensator.reset();
      CHECK(compensator.step(0.5 + output, 0.0).out_of_range == out);
    }
  }
}

TEST_CASE("exact ends: a divider's full output may be 0.995 of its highest, whatever the unloaded output",
          "[dynamic]") {
  // u = 6 V gives 6 / (1 + 6 / A), which is 0.995 A where 6 / A is 199.
  const auto taken = [](double per_amplitude, double zero) {
    DynamicSetup setup = straight_setup();
    setup.taxels[0].divider = {zero, per_amplitude};
    try {
      check_taxel(setup, setup.taxels[0]);
    } catch (const std::invalid_argument& error) {
      CHECK(std::string(error.what()) == "dynamic compensator: its full output exceeds its divider's");
      return false;
    }
    return true;
  };
  for (const double zero : {0.0, 0.5, -7.0}) {
    CHECK(taken(0.0, zero));
    CHECK(taken(33.16, zero));
    CHECK_FALSE(taken(33.18, zero));
  }
}
