#include "bench/benchmarks/figure.h"

#include <time.h>

#include <algorithm>
#include <limits>
#include <numeric>

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

double now_s(By by) {
  timespec time{};
  ::clock_gettime(by == By::kWall ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

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

}  // namespace tactbench::bench
