// `benchmark charts` counts alarms as it says: figures whose every run is given, not drawn.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "analysis/statistics/control/ewma_chart.h"
#include "bench/benchmarks/charts.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

constexpr double kFarOff = 1e6;                // outside every band, and left out of every average
constexpr double kBelow = 2.2, kAbove = 2.18;  // steps that alarm just so, and just not: 4.48 and 4.67 %

// Baselines of eight runs -1, 1, -1, 1 ...; then 0 in each run, but for what is set.
class GivenHistories {
 public:
  explicit GivenHistories(std::vector<std::map<int, double>> later) : later_(std::move(later)) {}
  ChartDraw draw() {
    return [this](std::mt19937_64&) {
      if (ended_) start_next();
      const int now = run_++;
      if (now < 8) return now % 2 == 0 ? -1.0 : 1.0;
      const auto& own = later_.at(history_);
      const auto found = own.find(now - 7);
      ended_ = now == 67 || (found != own.end() && found->second == kFarOff);
      return found == own.end() ? 0.0 : found->second;
    };
  }
  [[nodiscard]] std::size_t history() const { return history_; }
  [[nodiscard]] int run() const { return run_ - 8; }  // of the last value given

 private:
  void start_next() {
    ++history_;
    run_ = 0;
    ended_ = false;
  }
  std::vector<std::map<int, double>> later_;
  std::size_t history_ = 0;
  int run_ = 0;
  bool ended_ = false;
};

ChartFound found_in(std::vector<std::map<int, double>> later, double step = 0.0, double ramp = 0.0) {
  const int draws = static_cast<int>(later.size());
  GivenHistories given(std::move(later));
  std::mt19937_64 random(1);
  return chart_found(draws, 8, given.draw(), step, ramp, random);
}

// Figures of nights: figure `i` has its baseline first, then a value each night.
class GivenNights {
 public:
  std::map<std::pair<int, int>, double> later;  // by night from 0 and figure
  ChartDraw draw() {
    return [this](std::mt19937_64&) {
      const int now = count_++ % (671 * 68);
      if (now < 671 * 8) return now % 2 == 0 ? -1.0 : 1.0;
      const int night = now / 671 - 8 + 60 * ((count_ - 1) / (671 * 68));
      const auto found = later.find({night, now % 671});
      return found == later.end() ? 0.0 : found->second;
    };
  }
  [[nodiscard]] int count() const { return count_; }

 private:
  int count_ = 0;
};

}  // namespace

TEST_CASE("benchmark charts: the share of histories with an alarm, and the middle one's run") {
  const ChartFound one = found_in({{{3, kFarOff}}, {}, {{5, kFarOff}}, {{1, kFarOff}}});
  CHECK(one.share == 0.75);
  CHECK(one.median == 3.0);
  const ChartFound two = found_in({{{60, kFarOff}}, {{2, kFarOff}}});  // of an even number the later one
  CHECK(two.share == 1.0);
  CHECK(two.median == 60.0);
  const ChartFound none = found_in({{}, {}});
  CHECK(none.share == 0.0);
  CHECK(none.median == 0.0);
}

TEST_CASE("benchmark charts: a history ends with its alarm, or after sixty runs") {
  GivenHistories given({{{61, kFarOff}}, {{4, kFarOff}}});
  std::mt19937_64 random(1);
  CHECK(chart_found(2, 8, given.draw(), 0.0, 0.0, random).median == 4.0);
  CHECK(given.history() == 1);
  CHECK(given.run() == 4);
}

TEST_CASE("benchmark charts: one figure alone alarms below a probability of 4.5 %") {
  const auto least_probability = [](double step) {
    const std::vector<double> start_up{-1, 1, -1, 1, -1, 1, -1, 1};
    analysis::EwmaChart chart = *analysis::EwmaChart::begin(start_up);
    double least = 1.0;
    for (int run = 0; run < 60; ++run) {
      chart.add(step);
      least = std::min(least, chart.probability());
    }
    return least;
  };
  CHECK(least_probability(kBelow) < 0.045);
  CHECK(least_probability(kBelow) > 0.042);
  CHECK(least_probability(kAbove) > 0.045);
  CHECK(least_probability(kAbove) < 0.048);
  CHECK(found_in({{}}, kBelow).share == 1.0);
  CHECK(found_in({{}}, kAbove).share == 0.0);
  // A ramp begins with the first run: 0.5, 1, 1.5 ... is what the step alone gives where the runs are given so.
  std::map<int, double> ramp;
  for (int run = 1; run <= 60; ++run) ramp[run] = 0.5 * run;
  const double alarm = found_in({ramp}).median;
  CHECK(found_in({{}}, 0.0, 0.5).median == alarm);
  CHECK(alarm == 8.0);
  CHECK(found_in({{}}, 0.5, 0.5).median == 6.0);
  CHECK(found_in({{}}, -0.5, 0.5).median == 9.0);
}

TEST_CASE("benchmark charts: nights without a change have nothing to report") {
  GivenNights given;
  std::mt19937_64 random(1);
  const ChartNights none = chart_nights(1, 8, given.draw(), 0, 0.0, random);
  CHECK(given.count() == 671 * 68);
  CHECK(none.false_nights == 0.0);
  CHECK(none.false_periods == 0.0);
  CHECK(none.gross_nights == 0.0);
  CHECK(none.found == 0.0);
  CHECK(none.false_share == 0.0);
}

TEST_CASE("benchmark charts: changed figures are found, and others of the same nights are false") {
  // The first two of 671 change. In the first of two periods figure 2, which did not, is far off in nights 10 and 11,
  // and figure 5 lies four deviations away from night 30 on; in the second all others stay.
  GivenNights given;
  given.later[{10, 2}] = given.later[{11, 2}] = kFarOff;
  for (int night = 30; night < 60; ++night) given.later[{night, 5}] = 8.0;
  std::mt19937_64 random(1);
  const ChartNights nights = chart_nights(2, 8, given.draw(), 2, 8.0, random);
  CHECK(given.count() == 2 * 671 * 68);
  CHECK(nights.found == 100.0);
  CHECK(nights.gross_nights == Approx(100.0 * 2 / 120));
  CHECK(nights.false_periods == 50.0);
  CHECK(nights.false_share == Approx(100.0 * (1.0 / 3.0) / 2));
  CHECK(nights.false_nights == Approx(100.0 * 25 / 120));  // reported from its sixth night on
}
