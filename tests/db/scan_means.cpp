// Scans of a frame: which sample the others contradict, and the mean of those that are left.
#include <catch2/catch.hpp>
#include <cmath>

#include "db/record.h"

using namespace tactbench;

namespace {

using Counts = std::vector<std::uint16_t>;

// Of one taxel.
double mean_of(const Counts& scans, std::vector<double> before = {}) {
  return db::scan_means(scans, scans.size(), before).front();
}

}  // namespace

TEST_CASE("scans: a sample far from the majority of the others is left out of the mean") {
  CHECK(mean_of({5000, 5004}) == 5002.0);
  CHECK(mean_of({5000, 8200}) == 6600.0);  // within 5 % of the converter: noise, or a load that moves
  CHECK(mean_of({5000, 65535, 5004}) == 5002.0);
  CHECK(mean_of({0, 5000, 5004, 5008}) == 5004.0);
  CHECK(mean_of({30000, 5000, 5004}) == 5002.0);
  CHECK(mean_of({65535}) == 65535.0);                      // there is no other
  CHECK(mean_of({5000, 5000, 65535, 65535}) == 35267.5);   // no majority here either
  CHECK(mean_of({65535, 65535, 65535, 5000}) == 65535.0);  // the taxel is at the limit
}

TEST_CASE("scans: of two that differ, the one near the previous frame counts, else the one not at a limit") {
  CHECK(mean_of({5600, 65535}) == 5600.0);
  CHECK(mean_of({0, 5600}) == 5600.0);
  CHECK(mean_of({5600, 30000}) == 17800.0);
  CHECK(mean_of({5600, 30000}, {5000.0}) == 5600.0);
  CHECK(mean_of({65535, 61000}, {62000.0}) == 61000.0);
  CHECK(mean_of({5600, 30000}, {18000.0}) == 17800.0);  // as far from both
}

TEST_CASE("scans: means are per taxel, and a disagreement of any taxel is reported") {
  const Counts frame = {100, 200, 300, 104, 65535, 300};  // two scans of three taxels
  CHECK(db::scan_means(frame, 2) == std::vector<double>{102.0, 200.0, 300.0});
  CHECK(db::scans_disagree(frame, 2));
  CHECK_FALSE(db::scans_disagree(Counts{100, 200, 300, 104, 210, 300}, 2));
  CHECK_FALSE(db::scans_disagree(Counts{100, 200, 65535}, 1));
  CHECK(std::isnan(db::consensus_count(frame, 2, 0, {100.0, 100.0})));
  CHECK(db::consensus_count(frame, 2, 1, {100.0, 300.0}) == 200.0);
}
