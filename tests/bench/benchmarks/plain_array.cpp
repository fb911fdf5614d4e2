// The simplest form of an array that `benchmark array` compares the simulated one with.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "bench/benchmarks/array.h"

using namespace tactbench::bench;

namespace {

struct PlainVolts {
  double mean = 0.0, deviation = 0.0;
};

PlainVolts volts_of(const PlainArray& array) {
  PlainVolts volts;
  for (const std::uint16_t counts : array.counts()) volts.mean += counts * (5.0 / 65535.0) / 256.0;
  for (const std::uint16_t counts : array.counts())
    volts.deviation += std::pow(counts * (5.0 / 65535.0) - volts.mean, 2) / 256.0;
  volts.deviation = std::sqrt(volts.deviation);
  return volts;
}

}  // namespace

TEST_CASE("benchmark array: the plain form's play operators of 0 to 11 psi, up and down, with 1.5 mV of noise") {
  PlainArray array;
  CHECK(array.counts().size() == 256);
  // Up, each lies behind by its width, 66 psi together; down, none leaves its place before it is reached.
  array.frame(30.0);
  CHECK(volts_of(array).mean == Approx(0.005 * (12 * 30.0 - 66.0)).margin(0.0005));
  CHECK(volts_of(array).deviation == Approx(0.0015).epsilon(0.15));
  array.frame(19.0);
  CHECK(volts_of(array).mean == Approx(0.005 * 12 * 19.0).margin(0.0005));
  array.frame(20.0);  // those of 0 and 1 psi: 20 and 19
  CHECK(volts_of(array).mean == Approx(0.005 * (20.0 + 11 * 19.0)).margin(0.0005));
  array.frame(22.0);  // 22, 21, 20 and nine at 19
  CHECK(volts_of(array).mean == Approx(0.005 * (22.0 + 21.0 + 20.0 + 9 * 19.0)).margin(0.0005));
  array.frame(0.0);
  CHECK(volts_of(array).mean == Approx(0.0006).margin(0.0004));  // noise below 0 V is cut off: 0.4 of its deviation
  CHECK(std::ranges::count(array.counts(), 0) > 64);             // of half of the taxels
  array.frame(100.0);
  CHECK(volts_of(array).mean == Approx(5.0).margin(1e-9));  // the converter's end
}

TEST_CASE("benchmark array: pressures go from 0 to 60 psi and back in 200 frames") {
  CHECK(benchmarked_pressure(0) == 0.0);
  CHECK(benchmarked_pressure(50) == Approx(30.0).epsilon(1e-6));
  CHECK(benchmarked_pressure(100) == Approx(60.0).epsilon(1e-6));
  CHECK(benchmarked_pressure(150) == Approx(30.0).epsilon(1e-6));
  CHECK(benchmarked_pressure(200) == Approx(0.0).margin(1e-6));
  CHECK(benchmarked_pressure(25) == Approx(30.0 - 30.0 / std::sqrt(2.0)).epsilon(1e-6));
}
