// What `tactbench benchmark compensate-dynamic` measures on: films worked out in Python from the same seed, frames
// along known pressures. And its figures, worked out by hand from round numbers.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bench/benchmarks/compensate_dynamic.h"

using namespace tactbench;

namespace {

// Places of pressures of 3 psi each in the table.
double everett_at(const analysis::DynamicTaxel& taxel, std::size_t high, std::size_t low) {
  return taxel.everett.at(high * (high + 1) / 2 + low);
}

struct KnownFilm {
  double per_amplitude, first, top, last, middle, half, near;
};

void check_film(const analysis::DynamicTaxel& taxel, const KnownFilm& known) {
  REQUIRE(taxel.everett.size() == 21 * 22 / 2);
  const auto near_to = [](double value) { return Approx(value).epsilon(1e-11); };
  CHECK(taxel.divider.per_amplitude == near_to(known.per_amplitude));
  CHECK(everett_at(taxel, 1, 0) == near_to(known.first));
  CHECK(everett_at(taxel, 20, 0) == near_to(known.top));
  CHECK(everett_at(taxel, 20, 19) == near_to(known.last));
  CHECK(everett_at(taxel, 10, 5) == near_to(known.middle));
  CHECK(everett_at(taxel, 20, 10) == near_to(known.half));
  CHECK(everett_at(taxel, 3, 1) == near_to(known.near));
  for (std::size_t i = 0; i <= 20; ++i) CHECK(everett_at(taxel, i, i) == 0.0);
}

}  // namespace

TEST_CASE("benchmark compensate-dynamic: films of seed 5 with a divider, lag and creep") {
  const bench::DynamicCase c = bench::random_dynamic(2, 1);
  CHECK(c.setup.x_low == 0.0);
  CHECK(c.setup.x_high == 60.0);
  CHECK(c.setup.intervals == 20);
  CHECK(c.setup.volts_per_count == 5.0 / 65536.0);
  CHECK_FALSE(c.setup.start_unknown);
  CHECK(std::vector<double>(c.setup.dynamics.creep_share.begin(), c.setup.dynamics.creep_share.end()) ==
        std::vector<double>{0.015, 0.012, 0.01});
  REQUIRE(c.setup.taxels.size() == 2);
  check_film(c.setup.taxels[0], {0.24352071594049263, 0.12928615988026143, 20.0, 0.13955235487060025,
                                 3.7676874370446893, 8.872450927254278, 0.6863777350372493});
  check_film(c.setup.taxels[1], {0.24084029590580994, 0.5156733782177536, 20.0, 0.5533132180966903, 3.059179280399457,
                                 8.834863273780304, 1.1772205553557873});
  for (const analysis::DynamicTaxel& taxel : c.setup.taxels) {
    CHECK(taxel.usable);
    CHECK(taxel.divider.zero == 0.02);
    CHECK(taxel.lag_share == 0.07);
    CHECK(taxel.noise_v == 0.004);
  }
}

TEST_CASE("benchmark compensate-dynamic: random counts of seed 9, frame by frame") {
  const bench::DynamicCase c = bench::random_dynamic(4, 2);
  CHECK(c.frames == 2);
  CHECK(c.counts == std::vector<std::uint16_t>{15286, 20935, 316, 13263, 558, 36793, 5768, 5813});
}

TEST_CASE("benchmark compensate-dynamic: slow frames go 0-60-10-50-0 psi in phase, with 4 mV of noise") {
  constexpr std::size_t kFilms = 40, kFrames = 400;
  const bench::DynamicCase c = bench::slow_dynamic(kFilms, kFrames);
  CHECK(c.frames == kFrames);
  REQUIRE(c.counts.size() == kFilms * kFrames);
  double squares = 0.0, sum = 0.0, largest = 0.0;
  int looked = 0;
  const auto look = [&](std::size_t frame, std::size_t t, double u) {
    const double share = u * c.setup.taxels[t].divider.per_amplitude;
    const double error = c.counts[frame * kFilms + t] * (5.0 / 65536.0) - (0.02 + u / (1.0 + share));
    squares += error * error;
    sum += error;
    largest = std::max(largest, std::abs(error));
    ++looked;
  };
  for (std::size_t t = 0; t < kFilms; ++t) {
    const analysis::DynamicTaxel& taxel = c.setup.taxels[t];
    // Multiples of 3 psi: each fifth of the first hundred frames, going up; and on the way down from 60 psi each
    // sixth, to 12 psi; frame 100 is at the top itself.
    for (std::size_t k = 2; k <= 20; ++k) look(5 * k, t, everett_at(taxel, k, 0));
    for (std::size_t k = 1; k <= 16; ++k) look(100 + 6 * k, t, 20.0 - everett_at(taxel, 20, 20 - k));
    // At 0.5 psi the inner loop is forgotten: of what switches off in the last 3 psi a sixth is left.
    look(399, t, (20.0 - everett_at(taxel, 20, 1)) / 6.0);
  }
  CHECK(looked == 40 * 36);
  CHECK(std::sqrt(squares / looked) == Approx(0.004).epsilon(0.1));
  CHECK(std::abs(sum / looked) < 0.0005);
  CHECK(largest < 0.02);
}

TEST_CASE("benchmark compensate-dynamic: microseconds a frame by vector level, goals of one level, and bytes a taxel") {
  bench::CompensateDynamicTimes times;
  times.slow_frames = 2000;
  times.random_frames = 100;
  times.levels = {{"base", 0.002, 0.0003, 0.004, 0.0005}, {"avx2", 0.006, 0.0007, 0.008, 0.0009}};
  times.bytes_per_taxel = 1234;
  std::string text;
  for (const bench::Figure& figure : figures_of(times))
    text += fmt::format("{} {:.7g} {}\n", figure.name, figure.value, figure.unit);
  CHECK(text ==
        "compensate-dynamic_slow_base 1 us/frame\n"
        "compensate-dynamic_turning_base 3 us/frame\n"
        "compensate-dynamic_slow_elam_base 2 us/frame\n"
        "compensate-dynamic_turning_elam_base 5 us/frame\n"
        "compensate-dynamic_slow_avx2 3 us/frame\n"
        "compensate-dynamic_slow_avx2_goal_at_most 2 us/frame\n"
        "compensate-dynamic_turning_avx2 7 us/frame\n"
        "compensate-dynamic_turning_avx2_goal_at_most 12 us/frame\n"
        "compensate-dynamic_slow_elam_avx2 4 us/frame\n"
        "compensate-dynamic_turning_elam_avx2 9 us/frame\n"
        "compensate-dynamic_memory_a_taxel 1234 bytes\n"
        "compensate-dynamic_memory_a_taxel_goal_at_most 2048 bytes\n");
}

TEST_CASE("benchmark compensate-dynamic: on small arrays it measures each level of the processor") {
  std::string names;
  for (const bench::Figure& figure : bench::benchmark_compensate_dynamic(1, {3, 120, 20})) {
    INFO(figure.name);
    CHECK(figure.value > 0.0);
    if (figure.name.find("_avx") == std::string::npos) names += figure.name.substr(19) + " ";
  }
  CHECK(names == "slow_base turning_base slow_elam_base turning_elam_base memory_a_taxel memory_a_taxel_goal_at_most ");
}
