// A dynamic setup of the C API: 0 stands for each number's default, and another number changes what is read.
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "analysis/compensate/compensator_c.h"

namespace {

// 0 to 60 psi in two intervals: 0, 1 and 3 V going up, 3, 2 and 0 V coming down.
constexpr double kLoopTable[] = {0, 1, 0, 3, 1, 0};

struct DynamicNumbers {
  tb_dynamic_setup setup{};
  tb_dynamic_taxel taxel{};
  DynamicNumbers() {
    setup.struct_size = sizeof setup;
    setup.flags = TB_COMPENSATOR_DOUBLE;  // from an unknown history
    setup.taxels = 1;
    setup.intervals = 2;
    setup.pressure_high = 60.0;
    setup.volts_per_count = 5e-5;
    const double seconds[] = {2.0, 20.0, 200.0}, shares[] = {0.05, 0.04, 0.03};
    for (int j = 0; j < 3; ++j) {
      setup.creep_seconds[j] = seconds[j];
      setup.creep_share[j] = shares[j];
    }
    taxel.struct_size = sizeof taxel;
    taxel.flags = TB_TAXEL_USABLE;
    taxel.everett = kLoopTable;
    taxel.lag_share = 0.1;
    taxel.noise_volts = 0.01;
  }
};

// Pressures, uncertainties and states of frames one second apart, with two tares and more lost frames than a gap may
// have.
std::vector<double> readings_of(const DynamicNumbers& numbers) {
  tb_compensator* handle = nullptr;
  char message[120] = "";
  const int code = tb_compensator_create_dynamic(&numbers.setup, &numbers.taxel, &handle, message, sizeof message);
  INFO(message);
  REQUIRE(code == TB_COMPENSATOR_OK);
  std::vector<double> read;
  REQUIRE(tb_compensator_set_interval(handle, 1.0) == TB_COMPENSATOR_OK);
  const auto frame = [&](double volts) {
    double pressure = 0.0, uncertainty = 0.0;
    std::uint16_t status = 0;
    REQUIRE(tb_compensator_volts_double(handle, &volts, 1, &pressure, &uncertainty, &status) == TB_COMPENSATOR_OK);
    read.insert(read.end(), {pressure, uncertainty, static_cast<double>(status)});
  };
  const auto way = [&] {
    for (const double volts : {0.1, 0.3, 0.5, 0.2, 0.05, 0.6, 1.2, 2.0, 2.9, 2.95, 2.4, 1.0, 0.3, 0.9, 1.5, 0.01, 0.0})
      frame(volts);
  };
  way();
  for (const auto counts :
       {std::uint16_t{12'500}, std::uint16_t{11'500}}) {  // 0.625 and 0.575 V: a fifth of the span is 0.6
    size_t refused = 0;
    REQUIRE(tb_compensator_tare(handle, &counts, 1, &refused) == TB_COMPENSATOR_OK);
    read.push_back(static_cast<double>(refused));
  }
  REQUIRE(tb_compensator_reset(handle) == TB_COMPENSATOR_OK);
  for (const int lost : {10, 11}) {
    frame(1.2);
    for (int i = 0; i < lost; ++i) REQUIRE(tb_compensator_lost_frame(handle) == TB_COMPENSATOR_OK);
    frame(0.9);
    frame(0.8);
  }
  REQUIRE(tb_compensator_reset(handle) == TB_COMPENSATOR_OK);
  way();
  tb_compensator_destroy(handle);
  return read;
}

}  // namespace

TEST_CASE("C API: each number of a dynamic setup has the default that the header tells, for which 0 stands") {
  const std::vector<double> plain = readings_of({});
  const auto with = [](auto change) {
    DynamicNumbers numbers;
    change(numbers);
    return readings_of(numbers);
  };
  CHECK(with([](DynamicNumbers& n) { n.taxel.creep_scale = 1.0; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.taxel.creep_scale = 1.125; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.creep_half = 10.0; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.creep_half = 11.0; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.lag_seconds = 1.0; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.lag_seconds = 1.125; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.top_share = 0.02; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.tare_share = 0.2; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.tare_share = 0.25; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.longest_gap = 10; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.longest_gap = 11; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.longest_gap = 9; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.longest_gap = 0xffffffffU; }) ==
        with([](DynamicNumbers& n) { n.setup.longest_gap = 0x7fffffffU; }));
  CHECK(with([](DynamicNumbers& n) { n.setup.flat_pressure = 2.0; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.flat_pressure = 0.25; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.known_pressure = 0.5; }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.known_pressure = 20.0; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.taxel.noise_volts = 0.011; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.taxel.lag_share = 0.2; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.taxel.zero_volts = 0.1; }) != plain);
  CHECK(with([](DynamicNumbers& n) { n.taxel.per_amplitude = 0.1; }) != plain);
  for (int j = 0; j < 3; ++j) {
    CHECK(with([j](DynamicNumbers& n) { n.setup.creep_seconds[j] *= 1.125; }) != plain);
    CHECK(with([j](DynamicNumbers& n) { n.setup.creep_share[j] *= 1.125; }) != plain);
  }
  CHECK(with([](DynamicNumbers& n) { n.setup.worked_seconds = 100.0; }) != plain);
  const double left[] = {0.5, 0.6, 0.7, 0.8};  // by interval, rising and falling
  const auto with_left = [&](double scale) {
    return with([&](DynamicNumbers& n) {
      n.setup.residual = left;
      n.taxel.residual_scale = scale;
    });
  };
  CHECK(with_left(0.0) != plain);
  CHECK(with_left(0.0) == with_left(1.0));
  CHECK(with_left(0.0) != with_left(2.0));
  // A struct that ends before the last member has none of it.
  CHECK(with([](DynamicNumbers& n) {
          n.setup.worked_seconds = 100.0;
          n.setup.struct_size -= sizeof(double);
        }) == plain);
  CHECK(with([](DynamicNumbers& n) { n.setup.flags |= TB_COMPENSATOR_START_AT_REST; }) != plain);
}

TEST_CASE("C API: a dynamic setup has 1 to 100 intervals and some taxels, else the size is wrong") {
  const auto code = [](std::size_t taxels, std::size_t intervals) {
    std::vector<double> table;
    for (std::size_t i = 0; i <= intervals; ++i)
      for (std::size_t j = 0; j <= i; ++j) table.push_back(static_cast<double>(i - j));
    DynamicNumbers numbers;
    numbers.setup.taxels = taxels;
    numbers.setup.intervals = intervals;
    numbers.taxel.everett = table.data();
    tb_compensator* handle = nullptr;
    const int told = tb_compensator_create_dynamic(&numbers.setup, &numbers.taxel, &handle, nullptr, 0);
    CHECK((told == TB_COMPENSATOR_OK) == (handle != nullptr));
    tb_compensator_destroy(handle);
    return told;
  };
  for (const std::size_t intervals : {1U, 100U}) CHECK(code(1, intervals) == TB_COMPENSATOR_OK);
  for (const std::size_t intervals : {0U, 101U}) CHECK(code(1, intervals) == TB_COMPENSATOR_SIZE);
  CHECK(code(0, 1) == TB_COMPENSATOR_SIZE);
}
