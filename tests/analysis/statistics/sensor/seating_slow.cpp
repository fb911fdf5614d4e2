// The seating check raises no alarm on many arrays that are mounted well.
#include <catch2/catch.hpp>

#include "tests/analysis/statistics/sensor/seated.h"

using namespace tactbench;
using namespace tactbench::analysis;
using bench::SpecimenOptions;

TEST_CASE("seating: 200 well seated arrays pass, when new and when mounted again a month later and warmer") {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const SeatingFrames first = seated(sensor(seed), seed);
    SpecimenOptions later = mounted_again(seed);
    later.temperature_c = 28.0;
    later.age_months = 1.0;
    later.effects.gain_drift_per_month = 0.01;
    later.effects.zero_drift_v_per_month = 0.01;
    for (const SeatingResult& result :
         {check_seating(16, 16, first, std::nullopt), check_seating(16, 16, seated(later, seed + 1000), first)}) {
      alarms += result.verdict == "pass" ? 0 : 1;
      if (!result.findings.empty()) UNSCOPED_INFO(seed << ": " << result.findings.front().text);
    }
  }
  CHECK(alarms == 0);
}
