// Pressures of the bench file that are typed on the command line in another unit.
#include <catch2/catch.hpp>
#include <string>

#include "bench/common/overrides.h"
#include "bench/config/config.h"

using namespace tactbench;
using namespace tactbench::bench;
using sequences::FileError;

namespace {

BenchConfig bench_with(const std::string& typed) {
  return read_bench(find_config("simulated.toml"), split_overrides({typed}).bench);
}

}  // namespace

TEST_CASE("a pressure typed in another unit is refused with both what it is and what was typed") {
  try {
    (void)bench_with("limits.trip_psi=9bar");
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("130.534") && Catch::Contains("9bar") && Catch::Contains("60 to 110"));
    CHECK_THAT(error.where(), Catch::Contains("--set limits.trip_psi"));
  }
  CHECK(bench_with("limits.trip_psi=450kPa").limits.trip_psi == Approx(65.267).epsilon(1e-4));
}
