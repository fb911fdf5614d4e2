// selfcheck's comparisons of vector levels and of compensated pressures with known ones: what each line says. Not a
// unit test: arrays are identified by several threads.
#include <catch2/catch.hpp>
#include <cstdio>

#include "bench/selfcheck/selfcheck.h"

using namespace tactbench::bench;

TEST_CASE("selfcheck's levels: the same bits from each vector level, and frames that do not differ") {
  const SelfcheckLines lines = check_dispatch_levels();
  REQUIRE_FALSE(lines.empty());
  for (const SelfcheckLine& line : lines) {
    INFO(line.what << ": " << line.found);
    CHECK(line.area == "dispatch");
    CHECK(line.pass);
    if (&line == &lines.back()) continue;
    CHECK_THAT(line.what, Catch::StartsWith("identification of 12 taxels, base against avx"));
    CHECK(line.expected == "the same bits");
    CHECK(line.found == "the same bits");
  }
  CHECK_THAT(lines.back().what, Catch::StartsWith("compensated frames, base against "));
  CHECK(lines.back().expected == "0 frames differ");
  CHECK(lines.back().found == "0 of 1732 frames differ");
}

TEST_CASE("selfcheck's compensator: pressures of known outputs, all of them observable") {
  const SelfcheckLines lines = check_compensator();
  REQUIRE(lines.size() == 1);
  INFO(lines[0].found);
  CHECK(lines[0].area == "compensator");
  CHECK(lines[0].what == "pressures from the direct formula's outputs, random reversals");
  CHECK(lines[0].expected == "within 1e-06 psi where the pressure is observable, at least 9 samples in 10");
  CHECK(lines[0].pass);
  double worst = 0.0;
  int observable = 0, samples = 0;
  REQUIRE(std::sscanf(lines[0].found.c_str(), "within %lf psi, %d of %d samples", &worst, &observable, &samples) == 3);
  CHECK(worst < 1e-9);  // without noise, drift and dead band
  CHECK(samples == 29256);
  CHECK(observable == samples);
}
