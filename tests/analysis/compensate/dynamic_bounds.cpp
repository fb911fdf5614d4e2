// The numbers that a dynamic compensator is made of: each bound is taken, the next number beyond it is refused by name.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace tactbench::analysis;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity(), kNotANumber = std::numeric_limits<double>::quiet_NaN();

double above(double x) { return std::nextafter(x, kInf); }
double below(double x) { return std::nextafter(x, -kInf); }

// What a good setup of one taxel is refused for after `change`; empty: it is taken.
std::string refusal(const std::function<void(DynamicSetup&)>& change) {
  DynamicSetup setup = synthetic::dynamic_array(1, 0.004, 4).setup;
  change(setup);
  try {
    check_setup(setup);
    check_taxel(setup, setup.taxels.front());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

// `good` numbers are taken, `bad` ones refused by a message with `word` in it.
void check_number(const std::string& word, const std::function<double&(DynamicSetup&)>& number,
                  const std::vector<double>& good, const std::vector<double>& bad) {
  for (const double value : good) {
    INFO(word << " " << value);
    CHECK(refusal([&](DynamicSetup& setup) { number(setup) = value; }).empty());
  }
  for (const double value : bad) {
    INFO(word << " " << value);
    CHECK_THAT(refusal([&](DynamicSetup& setup) { number(setup) = value; }), Catch::Contains(word));
  }
}

}  // namespace

TEST_CASE("dynamic setup: what the array shares lies within its bounds", "[dynamic]") {
  CHECK(refusal([](DynamicSetup&) {}).empty());
  for (const std::size_t n : {0U, 101U})
    CHECK_THAT(refusal([n](DynamicSetup& s) { s.intervals = n; }), Catch::Contains("100"));
  const double least = std::numeric_limits<double>::denorm_min();
  for (std::size_t j = 0; j < kCreepElements; ++j) {
    check_number("creep time", [j](DynamicSetup& s) -> double& { return s.dynamics.creep_s[j]; }, {least, 1e9},
                 {0.0, -1.0, kInf, kNotANumber});
    check_number("creep share", [j](DynamicSetup& s) -> double& { return s.dynamics.creep_share[j]; }, {0.0, 0.5},
                 {-least, kNotANumber, kInf});
  }
  check_number("creep_half", [](DynamicSetup& s) -> double& { return s.dynamics.creep_half; }, {1e-9, 1e9},
               {0.0, -1.0, below(1e-9), above(1e9), kNotANumber});
  check_number("lag's time", [](DynamicSetup& s) -> double& { return s.dynamics.lag_s; }, {least, 1e9},
               {0.0, -1.0, kInf, kNotANumber});
  check_number("x_low", [](DynamicSetup& s) -> double& { return s.x_low; }, {-1e9, -10.0, 59.99},
               {60.0, 61.0, below(60.0), below(-1e9), kNotANumber});
  check_number("x_low", [](DynamicSetup& s) -> double& { return s.x_high; }, {1e-9, 1e9},
               {0.0, below(1e-9), above(1e9), kNotANumber});
  check_number("share is not", [](DynamicSetup& s) -> double& { return s.observer.share; }, {0.0, below(0.2)},
               {-least, 0.2, kNotANumber});
  check_number("forgets", [](DynamicSetup& s) -> double& { return s.observer.forget; }, {0.0, 1.0},
               {-least, above(1.0), kNotANumber});
  check_number("doubt", [](DynamicSetup& s) -> double& { return s.observer.doubt; }, {0.0, 1e9},
               {-least, above(1e9), kNotANumber});
  check_number("worked_s", [](DynamicSetup& s) -> double& { return s.worked_s; }, {0.0, 1e9},
               {-least, kInf, kNotANumber});
  for (const std::size_t count : {1U, 7U, 9U})
    CHECK_THAT(refusal([&](DynamicSetup& s) { s.residual_psi.assign(count, 0.1); }), Catch::Contains("two values"));
  check_number("a residual",
               [](DynamicSetup& s) -> double& {
                 s.residual_psi.assign(8, 0.1);
                 return s.residual_psi[7];
               },
               {0.0, 1e9}, {-least, above(1e9), kNotANumber});
}

TEST_CASE("dynamic setup: a taxel's own numbers and its table", "[dynamic]") {
  const double least = std::numeric_limits<double>::denorm_min();
  const auto own = [](double DynamicTaxel::*member) {
    return [member](DynamicSetup& s) -> double& { return s.taxels.front().*member; };
  };
  check_number("its noise", own(&DynamicTaxel::noise_v), {0.0, 1.0}, {-least, kInf, kNotANumber});
  check_number("residual_scale", own(&DynamicTaxel::residual_scale), {0.0, 1e6}, {-least, above(1e6), kNotANumber});
  check_number("its creep is", own(&DynamicTaxel::creep_scale), {0.0, 10.0}, {-least, above(10.0), kNotANumber});
  check_number("its lag", own(&DynamicTaxel::lag_share), {0.0, 0.9}, {-least, above(0.9), kNotANumber});
  check_number("its divider is", [](DynamicSetup& s) -> double& { return s.taxels.front().divider.zero; },
               {-1.0, 0.0, 1.0}, {kInf, kNotANumber});
  check_number("its divider is", [](DynamicSetup& s) -> double& { return s.taxels.front().divider.per_amplitude; },
               {0.0, 0.1}, {-least, kInf, kNotANumber});
  // A table of four intervals has fifteen values: (i, j) at i (i + 1) / 2 + j.
  const auto table = [](std::size_t at, double value) {
    return refusal([&](DynamicSetup& s) { s.taxels.front().everett.at(at) = value; });
  };
  const std::vector<double> good = synthetic::dynamic_array(1, 0.004, 4).setup.taxels.front().everett;
  REQUIRE(good.size() == 15);
  for (const std::size_t diagonal : {0U, 2U, 5U, 9U}) CHECK_THAT(table(diagonal, 1e-9), Catch::Contains("table"));
  CHECK_THAT(table(10, below(good[11])), Catch::Contains("table"));   // (4, 0) under (4, 1)
  CHECK(table(10, good[11] > good[6] ? good[11] : good[6]).empty());  // as high as both neighbours
  CHECK_THAT(table(3, below(good[1])), Catch::Contains("table"));     // (2, 0) under (1, 0)
  CHECK_FALSE(table(12, kNotANumber).empty());
  CHECK_FALSE(table(12, kInf).empty());
  for (const std::size_t size : {14U, 16U})
    CHECK_THAT(refusal([&](DynamicSetup& s) { s.taxels.front().everett.resize(size, 0.0); }), Catch::Contains("size"));
  CHECK_THAT(refusal([&](DynamicSetup& s) { s.taxels.front().everett.assign(15, 0.0); }),
             Catch::Contains("does not rise"));
}

// Single precision is the default, and what overflows in it is no number, of which no index can be made.
TEST_CASE("dynamic frames: numbers that a fit does not make are refused, voltages that no scanner gives are lost") {
  const auto refused = [](const std::function<void(DynamicSetup&)>& change) {
    DynamicSetup setup = synthetic::dynamic_array(20, 0.004, 4).setup;
    setup.volts_per_count = 5.0 / 65535;
    for (DynamicTaxel& taxel : setup.taxels) taxel.divider.per_amplitude = 0.0;
    change(setup);
    try {
      DynamicFrameCompensator<float> frames(setup);
      std::vector<float> volts(20), pressure(20), uncertainty(20);
      std::vector<std::uint16_t> status(20);
      std::mt19937 random(1);
      for (int frame = 0; frame < 50; ++frame) {
        frames.set_interval(frame % 2 == 0 ? 0.1 : 1e300);
        for (float& sample : volts) sample = static_cast<float>(random() % 7);
        volts[7] = std::array{1e30F, -1e30F, std::numeric_limits<float>::max(), 3.0F}.at(frame % 4);
        frames.frame(std::span<const float>(volts), {pressure, uncertainty, status});
        CHECK((status[7] == kTaxelLost) == (frame % 4 != 3));
        for (std::size_t i = 0; i < 20; ++i) CHECK((std::isfinite(pressure[i]) && std::isfinite(uncertainty[i])));
      }
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  const auto scaled = [&](double by) {
    return refused([by](DynamicSetup& s) {
      for (double& rise : s.taxels[3].everett) rise *= by;
    });
  };
  CHECK_FALSE(scaled(1.0));
  CHECK_FALSE(scaled(1e6));
  for (const double by : {1e-300, 1e-12, 1e12, 1e37, 1e300}) CHECK(scaled(by));
  for (const double zero : {1e10, -1e38, 1e300})
    CHECK(refused([zero](DynamicSetup& s) { s.taxels[3].divider.zero = zero; }));
  for (const double volts : {1e-300, 1e-13, 1e13, 1e300})
    CHECK(refused([volts](DynamicSetup& s) { s.volts_per_count = volts; }));
  CHECK(refused([](DynamicSetup& s) { s.taxels[3].noise_v = 1e37; }));
  // The least noise is that of rounding to a count. Steps so small beside the output that single precision has no slope
  // for them.
  CHECK_FALSE(refused([](DynamicSetup& s) {
    s.volts_per_count = 1e-9;
    for (DynamicTaxel& taxel : s.taxels) taxel.noise_v = 0.0;
  }));
  CHECK_FALSE(refused([](DynamicSetup& s) {
    for (double& rise : s.taxels[3].everett) rise = rise > 0.0 ? 1.0 + 1e-10 * rise : 0.0;
  }));
}
