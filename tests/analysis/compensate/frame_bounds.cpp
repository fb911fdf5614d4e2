// The numbers that a frame compensator is made of: each bound is taken, what lies beyond it is refused by name.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "analysis/compensate/frame_compensator.h"

using namespace tactbench::analysis;

namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity(),
                 kUndefined = std::numeric_limits<double>::quiet_NaN();

// Two taxels whose loops go from 0 to 3 V.
FrameSetup two_taxel_setup() {
  FrameSetup setup;
  setup.pressure_psi = {0.0, 30.0, 60.0};
  setup.volts_per_count = 1e-4;
  const TaxelSetup taxel{true, {0.0, 1.5, 3.0}, {0.0, 2.0, 3.0}, {0.5, 0.5, 0.0, 0.5, 0.5}, 0.001, false};
  setup.taxels = {taxel, taxel};
  return setup;
}

// What a good setup is refused for after `change`; empty: it is taken.
std::string frame_refusal(const std::function<void(FrameSetup&)>& change) {
  FrameSetup setup = two_taxel_setup();
  change(setup);
  try {
    const FrameCompensator<double> compensator(setup);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

void check_bounds(const std::string& place, const std::string& words, const std::function<double&(FrameSetup&)>& number,
                  const std::vector<double>& good, const std::vector<double>& bad) {
  for (const double value : good) {
    INFO(words << " " << value);
    CHECK(frame_refusal([&](FrameSetup& setup) { number(setup) = value; }).empty());
  }
  for (const double value : bad) {
    INFO(words << " " << value);
    CHECK_THAT(frame_refusal([&](FrameSetup& setup) { number(setup) = value; }),
               Catch::Contains(place) && Catch::Contains(words));
  }
}

}  // namespace

TEST_CASE("frame setup: what the array shares lies within its bounds") {
  const double least = std::numeric_limits<double>::denorm_min();
  CHECK(frame_refusal([](FrameSetup&) {}).empty());
  check_bounds("", "volts_per_count", [](FrameSetup& s) -> double& { return s.volts_per_count; }, {1e-9, 1.0},
               {0.0, -1e-4, 1e-13, 1e13, kUndefined});
  check_bounds("", "tare_share", [](FrameSetup& s) -> double& { return s.tare_share; }, {0.0, 2.0},
               {-least, kUndefined});
  check_bounds("", "pressures", [](FrameSetup& s) -> double& { return s.pressure_psi[1]; }, {1e-6, 59.999},
               {0.0, -1.0, 60.0, 60.0 - 1e-10, kUndefined, kEndless});
  check_bounds("", "pressures", [](FrameSetup& s) -> double& { return s.pressure_psi[0]; }, {-1e9, -10.0, 29.0},
               {30.0, kUndefined, -1.1e9});
  CHECK(frame_refusal([](FrameSetup& s) { s.longest_gap = 0; }).empty());
  CHECK_THAT(frame_refusal([](FrameSetup& s) { s.longest_gap = -1; }), Catch::Contains("longest_gap"));
  CHECK_THAT(frame_refusal([](FrameSetup& s) { s.taxels.clear(); }), Catch::Contains("no taxels"));
  CHECK_THAT(frame_refusal([](FrameSetup& s) { s.options.longest_mean = 0; }), Catch::Contains("longest_mean"));
  // Two knots are enough, one is not.
  const auto knots = [](std::size_t number) {
    return frame_refusal([number](FrameSetup& s) {
      s.pressure_psi.resize(number);
      for (TaxelSetup& taxel : s.taxels) {
        taxel.ascending_v.resize(number);
        taxel.descending_v = taxel.ascending_v;
      }
    });
  };
  CHECK(knots(2).empty());
  CHECK_THAT(knots(1), Catch::Contains("pressures"));
}

TEST_CASE("frame setup: a taxel's own numbers lie within their bounds, and the taxel is named") {
  const double least = std::numeric_limits<double>::denorm_min();
  for (double ElamParameters::*share : {&ElamParameters::alpha_d, &ElamParameters::beta_d, &ElamParameters::beta_a})
    check_bounds("taxel 1: ", "alpha_d, beta_d or beta_a",
                 [share](FrameSetup& s) -> double& { return s.taxels[1].parameters.*share; }, {0.0, 1.0},
                 {-least, std::nextafter(1.0, 2.0), kUndefined});
  for (double ElamParameters::*number : {&ElamParameters::alpha_a1, &ElamParameters::alpha_a0})
    check_bounds("taxel 1: ", "alpha_a1 or alpha_a0",
                 [number](FrameSetup& s) -> double& { return s.taxels[1].parameters.*number; }, {-3.0, 0.0, 3.0},
                 {kEndless, kUndefined});
  check_bounds("taxel 1: ", "noise", [](FrameSetup& s) -> double& { return s.taxels[1].noise_v; }, {0.0, 1.0},
               {-least, 1e4, kEndless, kUndefined});
  check_bounds("taxel 1: ", "residual",
               [](FrameSetup& s) -> double& {
                 for (TaxelSetup& taxel : s.taxels) taxel.residual_psi.assign(4, 0.1);
                 return s.taxels[1].residual_psi[3];
               },
               {0.0, 1e9}, {-least, 1.1e9, kUndefined});
  check_bounds("taxel 1: ", "patterns", [](FrameSetup& s) -> double& { return s.taxels[1].descending_v[0]; }, {0.0},
               {0.1, -0.1});
  check_bounds("taxel 1: ", "patterns", [](FrameSetup& s) -> double& { return s.taxels[1].ascending_v[2]; }, {3.0},
               {2.9, 3.1});
  for (std::vector<double> TaxelSetup::*pattern : {&TaxelSetup::ascending_v, &TaxelSetup::descending_v})
    for (const std::size_t size : {2U, 4U})
      CHECK_THAT(frame_refusal([&](FrameSetup& s) { (s.taxels[1].*pattern).resize(size, 3.0); }),
                 Catch::Contains("taxel 1: "));
  // Of a taxel that is not used nothing is read.
  CHECK(frame_refusal([](FrameSetup& s) {
          s.taxels[1].usable = false;
          s.taxels[1].noise_v = -1.0;
        }).empty());
}
