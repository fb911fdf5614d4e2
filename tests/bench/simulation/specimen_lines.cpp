// Specimens of one row or one column: their film's thickness still has its bowl and tilt along the line.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/simulation/specimen_film.h"

using namespace tactbench::bench;

namespace {

std::string amplitudes_of(int rows, int columns, std::uint64_t seed) {
  SpecimenOptions options;
  options.rows = rows;
  options.columns = columns;
  options.sensor_seed = seed;
  return fmt::format("{} x {}, seed {}: {:.6f}", rows, columns, seed, fmt::join(make_film(options).amplitude_v, " "));
}

void check_amplitudes(const std::vector<std::string>& said, const std::string& expected) {
  std::string all = "\n";
  for (const std::string& line : said) all += line + "\n";
  CHECK(all == expected);
}

}  // namespace

TEST_CASE("specimen of one line: amplitudes along a row and a column") {
  check_amplitudes({amplitudes_of(1, 6, 1), amplitudes_of(6, 1, 1), amplitudes_of(1, 6, 2), amplitudes_of(6, 1, 2),
                    amplitudes_of(2, 3, 1)},
                   R"(
1 x 6, seed 1: 3.580630 3.809826 3.629694 4.055966 3.945669 4.418771
6 x 1, seed 1: 3.945669 4.418771 3.629694 4.055966 3.580630 3.809826
1 x 6, seed 2: 4.392615 3.810765 3.288097 3.673453 4.125376 3.904392
6 x 1, seed 2: 3.904392 3.810765 3.288097 3.673453 4.392615 4.125376
2 x 3, seed 1: 3.809826 3.945669 4.418771 3.580630 3.629694 4.055966
)");
}
