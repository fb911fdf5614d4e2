// The result of a benchmark, and how times are measured.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace tactbench::bench {

struct Figure {
  std::string name;
  double value = 0.0;
  std::string unit;
};

// Figures of one benchmark: their names begin with its own.
class FigureList {
 public:
  explicit FigureList(std::string benchmark) : benchmark_(std::move(benchmark)) {}
  void add(const std::string& name, double value, const std::string& unit);
  // The figure, and its goal after it as <name>_goal_at_most or <name>_goal_at_least.
  void add_at_most(const std::string& name, double value, double goal, const std::string& unit = "x");
  void add_at_least(const std::string& name, double value, double goal, const std::string& unit = "x");
  [[nodiscard]] std::vector<Figure> take() { return std::move(figures_); }

 private:
  std::string benchmark_;
  std::vector<Figure> figures_;
};

// Wall clock for work that waits for disks or threads; processor time of this process, or of the calling thread, for
// what computes, so that other work on the machine does not count; that of processes that this one started, with those
// that they started, once they have ended.
enum class By { kWall, kProcessor, kThread, kEnded };
using BenchmarkClock = std::function<double(By)>;

double now_s(By by);  // seconds since some time

// In its scope now_s() asks `clock`, in all threads: for tests, which then know how long everything took.
class ClockInPlace {
 public:
  explicit ClockInPlace(BenchmarkClock clock);
  ~ClockInPlace();
  ClockInPlace(const ClockInPlace&) = delete;
  ClockInPlace& operator=(const ClockInPlace&) = delete;
};

// The best of the rounds: a mean would include the effect of other work.
double best_seconds(int rounds, const std::function<void()>& act, By by = By::kWall);

// Several in turn, round by round, so that a slow spell of the machine does not fall on one of them alone.
std::vector<double> best_seconds(int rounds, const std::vector<std::function<void()>>& acts, By by = By::kWall);

// Of a stream of frames: the sum over stretches of 100, each with its best round, because other work on the machine
// comes and goes.
double sum_of_best_seconds(int rounds, std::size_t frames, const std::function<void(std::size_t)>& act_on);

// Each of `times` acts by itself, by wall clock.
std::vector<double> microseconds_of_each(std::size_t times, const std::function<void(std::size_t)>& act_on);
// Their median.
double median_microseconds(int times, const std::function<void()>& act);

// Keeps the compiler from removing work whose result is not read.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

}  // namespace tactbench::bench
