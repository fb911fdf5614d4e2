#include "bench/benchmarks/figure.h"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::bench {

void FigureList::add(const std::string& name, double value, const std::string& unit) {
  figures_.push_back({benchmark_ + "_" + name, value, unit});
}

void FigureList::add_at_most(const std::string& name, double value, double goal, const std::string& unit) {
  add(name, value, unit);
  add(name + "_goal_at_most", goal, unit);
}

void FigureList::add_at_least(const std::string& name, double value, double goal, const std::string& unit) {
  add(name, value, unit);
  add(name + "_goal_at_least", goal, unit);
}

namespace {

BenchmarkClock& clock_in_place() {
  static BenchmarkClock clock;
  return clock;
}

double seconds_of_ended_processes() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double system_seconds(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

ClockInPlace::ClockInPlace(BenchmarkClock clock) { clock_in_place() = std::move(clock); }
ClockInPlace::~ClockInPlace() { clock_in_place() = nullptr; }

double now_s(By by) {
  if (clock_in_place()) return clock_in_place()(by);
  switch (by) {
    case By::kWall:
      return system_seconds(CLOCK_MONOTONIC);
    case By::kProcessor:
      return system_seconds(CLOCK_PROCESS_CPUTIME_ID);
    case By::kThread:
      return system_seconds(CLOCK_THREAD_CPUTIME_ID);
    case By::kEnded:
      break;
  }
  return seconds_of_ended_processes();
}

double best_seconds(int rounds, const std::function<void()>& act, By by) {
  return best_seconds(rounds, std::vector{act}, by).front();
}

std::vector<double> best_seconds(int rounds, const std::vector<std::function<void()>>& acts, By by) {
  std::vector<double> best(acts.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < acts.size(); ++i) {
      const double start = now_s(by);
      acts[i]();
      best[i] = std::min(best[i], now_s(by) - start);
    }
  }
  return best;
}

double sum_of_best_seconds(int rounds, std::size_t frames, const std::function<void(std::size_t)>& act_on) {
  constexpr std::size_t kStretch = 100;
  std::vector<double> best((frames + kStretch - 1) / kStretch, std::numeric_limits<double>::infinity());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t first = 0; first < frames; first += kStretch) {
      const std::size_t end = std::min(frames, first + kStretch);
      const double start = now_s(By::kWall);
      for (std::size_t f = first; f < end; ++f) act_on(f);
      double& least = best[first / kStretch];
      least = std::min(least, now_s(By::kWall) - start);
    }
  }
  return std::accumulate(best.begin(), best.end(), 0.0);
}

std::vector<double> microseconds_of_each(std::size_t times, const std::function<void(std::size_t)>& act_on) {
  std::vector<double> taken(times);
  for (std::size_t i = 0; i < times; ++i) {
    const double start = now_s(By::kWall);
    act_on(i);
    taken[i] = 1e6 * (now_s(By::kWall) - start);
  }
  return taken;
}

double median_microseconds(int times, const std::function<void()>& act) {
  return analysis::quantile_of(microseconds_of_each(static_cast<std::size_t>(times), [&](std::size_t) { act(); }), 0.5);
}

}  // namespace tactbench::bench
