// The clocks that the benchmarks read. Not a unit test: one of them is a thread's own.
#include <sys/resource.h>
#include <time.h>

#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "bench/benchmarks/figure.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

double seconds_by(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
}

// Between two readings of the system's own.
void check_between(By by, clockid_t clock) {
  const double before = seconds_by(clock), now = now_s(by), after = seconds_by(clock);
  CHECK(now >= before - 1e-9);
  CHECK(now <= after + 1e-9);
}

void compute_for(double seconds) {
  for (const double end = seconds_by(CLOCK_THREAD_CPUTIME_ID) + seconds; seconds_by(CLOCK_THREAD_CPUTIME_ID) < end;) {
  }
}

}  // namespace

TEST_CASE("benchmarks' clocks are the wall's, the process's and the thread's") {
  compute_for(0.01);  // in which this thread is not the only one
  std::thread other([] { compute_for(0.02); });
  other.join();
  for (int i = 0; i < 3; ++i) {
    check_between(By::kWall, CLOCK_MONOTONIC);
    check_between(By::kProcessor, CLOCK_PROCESS_CPUTIME_ID);
    check_between(By::kThread, CLOCK_THREAD_CPUTIME_ID);
  }
}

TEST_CASE("benchmarks' clock of ended processes is what the system counts of them, with those that they started") {
  const double before = now_s(By::kEnded);
  const tests::TemporaryFolder folder;
  const std::string script = "i=0; while [ $i -lt 20000 ]; do i=$((i + 1)); done; sh -c ':'";
  REQUIRE(tests::run_program("/bin/sh", {"-c", script}, folder.path()).code == 0);
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  const double seconds = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                         static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) / 1e6;
  CHECK(now_s(By::kEnded) == Approx(seconds).margin(1e-9).epsilon(0.0));
  CHECK(now_s(By::kEnded) > before);
}

TEST_CASE("benchmarks' clocks can be replaced for a while, and the best of the rounds is told by them") {
  std::vector<By> asked;
  // Readings in pairs; an act takes 7, 3, 5, 2, 6, 4 s.
  const std::vector<double> acts{7.0, 3.0, 5.0, 2.0, 6.0, 4.0};
  double now = 100.0;
  {
    const ClockInPlace clock([&](By by) {
      asked.push_back(by);
      if (asked.size() % 2 == 0) now += acts.at(asked.size() / 2 - 1);
      return now;
    });
    CHECK(best_seconds(3, std::vector<std::function<void()>>{[] {}, [] {}}, By::kThread) ==
          std::vector<double>{5.0, 2.0});
  }
  CHECK(asked == std::vector<By>(12, By::kThread));
  CHECK(now == 127.0);
  check_between(By::kWall, CLOCK_MONOTONIC);
}
