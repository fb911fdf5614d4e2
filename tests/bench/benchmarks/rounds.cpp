// How the benchmarks take rounds, stretches and medians, by a clock of the test's.
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <vector>

#include "bench/benchmarks/figure.h"
#include "tests/bench/benchmarks/counted_time.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// How many frames lie between two readings of the clock, by wall clock alone.
std::vector<std::size_t> stretches_of(int rounds, std::size_t frames, double& seconds) {
  std::vector<std::size_t> stretches;
  std::size_t expected = 0;
  bool inside = false;
  double now = 0.0;
  const ClockInPlace clock([&](By by) {
    CHECK(by == By::kWall);
    inside = !inside;
    if (inside) stretches.push_back(0);
    return now += inside ? 1000.0 : 1.0 + static_cast<double>(stretches.size());
  });
  seconds = sum_of_best_seconds(rounds, frames, [&](std::size_t f) {
    CHECK(inside);
    CHECK(f == expected);
    expected = (f + 1) % frames;
    ++stretches.back();
  });
  CHECK_FALSE(inside);
  return stretches;
}

}  // namespace

TEST_CASE("benchmark streams: stretches of a hundred frames and what is left, each with its best round") {
  using Stretches = std::vector<std::size_t>;
  double seconds = 0.0;
  CHECK(stretches_of(1, 1, seconds) == Stretches{1});
  CHECK(seconds == 2.0);  // the first stretch takes 2 s, the second 3 s ...
  CHECK(stretches_of(1, 100, seconds) == Stretches{100});
  CHECK(seconds == 2.0);
  CHECK(stretches_of(1, 101, seconds) == Stretches{100, 1});
  CHECK(seconds == 5.0);
  CHECK(stretches_of(2, 199, seconds) == Stretches{100, 99, 100, 99});
  CHECK(seconds == 5.0);
  CHECK(stretches_of(2, 200, seconds) == Stretches{100, 100, 100, 100});
  CHECK(seconds == 5.0);
  CHECK(stretches_of(3, 201, seconds) == Stretches{100, 100, 1, 100, 100, 1, 100, 100, 1});
  CHECK(seconds == 9.0);
  CHECK(stretches_of(1, 0, seconds).empty());
  CHECK(seconds == 0.0);
}

TEST_CASE("benchmark streams: a later round counts where it is the better one") {
  double now = 0.0;
  int reading = 0;
  // The stretches of two rounds take 8, 3, 4, 5 s.
  const std::vector<double> taken{8.0, 3.0, 4.0, 5.0};
  const ClockInPlace clock([&](By) {
    if (++reading % 2 == 0) now += taken.at(static_cast<std::size_t>(reading / 2 - 1));
    return now;
  });
  CHECK(sum_of_best_seconds(2, 150, [](std::size_t) {}) == 7.0);
}

TEST_CASE("benchmark acts by themselves: microseconds of each, and the median") {
  const tests::CountedTime time;
  std::vector<std::size_t> done;
  CHECK(microseconds_of_each(3, [&](std::size_t i) { done.push_back(i); }) == std::vector<double>{2e6, 4e6, 6e6});
  CHECK(done == std::vector<std::size_t>{0, 1, 2});
  int acts = 0;
  CHECK(median_microseconds(5, [&] { ++acts; }) == 12e6);  // of 8, 10, 12, 14 and 16 s
  CHECK(acts == 5);
  CHECK(median_microseconds(2, [] {}) == 20e6);
  CHECK(time.readings() == std::vector<By>(20, By::kWall));
  CHECK(microseconds_of_each(0, [](std::size_t) {}).empty());
}

TEST_CASE("benchmark rounds: none at all are an endless time") {
  CHECK(best_seconds(0, std::vector<std::function<void()>>{[] {}}) ==
        std::vector<double>{std::numeric_limits<double>::infinity()});
}
