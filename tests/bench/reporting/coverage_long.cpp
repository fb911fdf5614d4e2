// By command: the report's U against the truth, the plant's pressure, on sensors and histories that nothing was chosen
// on, by kind of history. What U is stated for has to hold.
#include <catch2/catch.hpp>

#include "tests/benchmarks/study/coverage.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// `stated`: sensors for which U of full sweeps, reversals and held pressures has to be stated, else a report that is
// valid for nothing would pass.
void check_coverage(bench::SpecimenKind specimen, std::uint64_t seed, int stated) {
  const TemporaryFolder folder;
  bench::CoverageOptions options;
  options.seed = seed;
  options.specimens = {specimen};
  options.sensors = 6;
  const bench::CoverageOfSpecimen found = bench::study_coverage(options, folder.path()).front();
  UNSCOPED_INFO(bench::markdown_of({found}));
  for (const bench::CoverageOfKind& kind : found.kinds) {
    CAPTURE(analysis::name_of(kind.kind));
    if (kind.kind != analysis::UseCondition::kSmallReversals) CHECK(kind.stated >= stated);
    if (kind.stated == 0) continue;
    CHECK(kind.percent >= 92.0);
    CHECK(kind.percent <= 98.5);
    CHECK(kind.outside <= 1);
    CHECK(kind.median_u_psi <= 1.3 * kind.half_width_psi);
  }
  for (const bench::CoveredSensor& sensor : found.sensors) CHECK(sensor.minutes <= 25.0);
}

}  // namespace

TEST_CASE(
    "U holds 92 to 98.5 % of the readings of the paper's specimen of each kind of history that it is stated for") {
  check_coverage(bench::SpecimenKind::kPaper, 4100, 5);
}

TEST_CASE("U holds 92 to 98.5 % of the readings of the harsh specimen of each kind of history that it is stated for") {
  check_coverage(bench::SpecimenKind::kHarsh, 4200, 4);
}
