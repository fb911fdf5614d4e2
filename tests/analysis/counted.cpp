#include "analysis/counted.h"

#include <catch2/catch.hpp>
#include <cstddef>

using tactbench::analysis::counted;

TEST_CASE("a counted noun is in the singular or plural as its number requires") {
  CHECK(counted(0, "frame") == "0 frames");
  CHECK(counted(1, "frame") == "1 frame");
  CHECK(counted(std::size_t{2}, "frame") == "2 frames");
  CHECK(counted(-1, "microstep") == "-1 microsteps");
  CHECK(counted(std::size_t{1}, "branch", "branches") == "1 branch");
  CHECK(counted(0L, "branch", "branches") == "0 branches");
}
