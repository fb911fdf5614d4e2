#include "bench/common/utc.h"

#include <catch2/catch.hpp>

using tactbench::bench::seconds_between;

TEST_CASE("between two times lie their seconds, none when they stand the wrong way round or cannot be read") {
  CHECK(seconds_between("2026-02-28T23:59:58Z", "2026-03-01T00:00:01Z") == 3.0);
  CHECK(seconds_between("2026-02-28T23:59:58Z", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("2026-03-01T00:00:01Z", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("2026-02-28T23:59:58Z", "yesterday") == 0.0);
}
