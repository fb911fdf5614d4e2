#include "bench/common/utc.h"

#include <catch2/catch.hpp>

using tactbench::bench::seconds_between;

TEST_CASE("seconds between two times, 0 in reverse order or for unreadable times") {
  CHECK(seconds_between("2026-02-28T23:59:58Z", "2026-03-01T00:00:01Z") == 3.0);
  CHECK(seconds_between("2026-02-28T23:59:58Z", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("2026-03-01T00:00:01Z", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("", "2026-02-28T23:59:58Z") == 0.0);
  CHECK(seconds_between("2026-02-28T23:59:58Z", "yesterday") == 0.0);
}
