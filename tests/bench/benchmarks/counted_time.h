// A clock by which the tests know how long everything took that a benchmark timed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <mutex>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::tests {

// In its scope reading n of any clock says n (n + 1) / 2 seconds: of acts that are timed one after the other the first
// takes 2 s, the second 4 s, the third 6 s.
class CountedTime {
 public:
  CountedTime() : place_([this](bench::By by) { return read(by); }) {}
  // Of which clocks, in their order.
  [[nodiscard]] std::vector<bench::By> readings() const { return readings_; }

 private:
  double read(bench::By by) {
    const std::lock_guard lock(mutex_);
    readings_.push_back(by);
    const auto n = static_cast<double>(readings_.size());
    return n * (n + 1.0) / 2.0;
  }
  std::mutex mutex_;
  std::vector<bench::By> readings_;
  bench::ClockInPlace place_;
};

// What the acts of a benchmark take by such a clock, in the order in which they are timed.
class ActsInOrder {
 public:
  double next() { return 2.0 * ++act_; }  // seconds
  double sum_of(int acts) {
    double sum = 0.0;
    for (int i = 0; i < acts; ++i) sum += next();
    return sum;
  }
  double median_of(int acts) {  // of an even number the upper one of the two in the middle
    const double median = 2.0 * (act_ + acts / 2 + 1);
    act_ += acts;
    return median;
  }
  // Those of later rounds take longer: the first one is the best.
  void pass(int acts) { act_ += acts; }

 private:
  int act_ = 0;
};

// Of this process: a benchmark leaves as many as there were before it.
inline std::ptrdiff_t descriptors_left_open() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::distance(begin(all), end(all));
}

}  // namespace tactbench::tests
