#include "bench/run/watch/stuck_rows.h"

#include <catch2/catch.hpp>
#include <cstdint>

using tactbench::bench::StuckRowWatch;

namespace {

// Two rows of two columns, two scans.
tactbench::devices::ScanSet scans_of(std::uint16_t first_row, std::uint16_t second_row) {
  tactbench::devices::ScanSet scans;
  scans.rows = 2;
  scans.columns = 2;
  scans.scans = 2;
  for (int k = 0; k < 2; ++k) {
    for (const std::uint16_t counts : {first_row, first_row, second_row, second_row}) scans.counts.push_back(counts);
  }
  return scans;
}

}  // namespace

TEST_CASE("stuck rows: counts that stay the same to the bit while the load changes") {
  StuckRowWatch watch;
  CHECK(watch.see(scans_of(100, 200), 0.0, 1.0).rows.empty());
  CHECK(watch.see(scans_of(100, 200), 0.5, 1.0).rows.empty());  // too little load to tell
  const auto one = watch.see(scans_of(150, 200), 2.0, 1.0);
  CHECK(one.rows == std::vector<int>{1});
  CHECK_FALSE(one.all);
  CHECK(watch.see(scans_of(160, 210), 4.0, 1.0).rows.empty());  // it moves again
  CHECK(watch.see(scans_of(160, 210), 6.0, 1.0).all);
  CHECK(watch.see(scans_of(0, UINT16_MAX), 6.0, 1.0).rows.empty());
  CHECK_FALSE(watch.see(scans_of(0, UINT16_MAX), 20.0, 1.0).all);  // at the converter's limits there is nothing to see
}
