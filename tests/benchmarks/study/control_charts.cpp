#include "tests/benchmarks/study/control_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "analysis/statistics/control/control_chart.h"

namespace tactbench::bench {
namespace {

using analysis::EwmaControlChart;
using Random = std::mt19937_64;
constexpr std::size_t kNightFigures = 671;  // of a night of the shipped suite

constexpr int kHistoryRuns = analysis::kControlRuns;
// One figure alone: what band and Mann-Kendall test alarmed falsely in 60 runs with 8 accepted ones, 4.6 %, less what
// the wide band takes of it.
constexpr double kOneFigure = 0.045;

double normal(Random& random) { return std::normal_distribution<double>()(random); }

// The largest of 256 exponential values: close to Gumbel's distribution about log 256, deviation 1.28, skewness 1.1.
double largest(Random& random) {
  const double below = std::uniform_real_distribution<double>()(random);
  return -std::log1p(-std::pow(below, 1.0 / 256.0));
}
double log_of_largest(Random& random) { return std::log(largest(random)); }

// A figure of one run.
using ChartDraw = std::function<double(Random& random)>;

struct Watched {
  EwmaControlChart chart;
  analysis::ControlBand band;
  [[nodiscard]] bool outside(double value) const { return !band.holds(value); }
};

Watched begin(int start_up, const ChartDraw& draw, Random& random) {
  std::vector<double> values;
  for (int i = 0; i < start_up; ++i) values.push_back(draw(random));
  return {*EwmaControlChart::begin(values), *analysis::control_band(values, analysis::kGrossFalseAlarm)};
}

struct ChartFound {
  double share = 0.0;   // of histories with an alarm in 60 runs
  double median = 0.0;  // run of the alarm, where there is one
};
// `draws` histories of one figure, each with a baseline of `start_up` runs; then every run is higher by `step`, and by
// `ramp` more with each run.
ChartFound chart_found(int draws, int start_up, const ChartDraw& draw, double step, double ramp, Random& random) {
  std::vector<double> runs;
  for (int i = 0; i < draws; ++i) {
    Watched own = begin(start_up, draw, random);
    for (int run = 1; run <= kHistoryRuns; ++run) {
      const double value = draw(random) + step + ramp * run;
      own.chart.add(value);
      if (!own.outside(value) && own.chart.probability() > kOneFigure) continue;
      runs.push_back(run);
      break;
    }
  }
  ChartFound result;
  result.share = static_cast<double>(runs.size()) / draws;
  if (runs.empty()) return result;
  std::ranges::nth_element(runs, runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2));
  result.median = runs[runs.size() / 2];
  return result;
}

// Percent.
struct ChartNights {
  double false_nights = 0.0, false_periods = 0.0;  // with a figure reported that did not change
  double gross_nights = 0.0;                       // nights with such a figure outside its wide band
  double found = 0.0;                              // of the changed figures, in a period
  double false_share = 0.0;                        // of the figures reported in a period, mean over the periods
};
// Periods of 60 nights of so many figures. `changed` of the figures step by `step` after the baseline.
ChartNights chart_nights(int periods, int start_up, const ChartDraw& draw, std::size_t changed, double step,
                         Random& random) {
  ChartNights sum;
  for (int period = 0; period < periods; ++period) {
    std::vector<Watched> watched;
    for (std::size_t i = 0; i < kNightFigures; ++i) watched.push_back(begin(start_up, draw, random));
    std::set<std::size_t> reported;
    for (int night = 0; night < kHistoryRuns; ++night) {
      std::vector<double> probabilities;
      bool false_one = false, gross = false;
      for (std::size_t i = 0; i < watched.size(); ++i) {
        const double value = draw(random) + (i < changed ? step : 0.0);
        watched[i].chart.add(value);
        probabilities.push_back(watched[i].chart.probability());
        gross = gross || (i >= changed && watched[i].outside(value));
      }
      const std::vector<bool> now = analysis::discoveries(probabilities);
      for (std::size_t i = 0; i < now.size(); ++i) {
        if (!now[i]) continue;
        reported.insert(i);
        false_one = false_one || i >= changed;
      }
      sum.false_nights += false_one ? 1.0 / kHistoryRuns : 0.0;
      sum.gross_nights += gross ? 1.0 / kHistoryRuns : 0.0;
    }
    const auto right = static_cast<double>(std::ranges::count_if(reported, [&](std::size_t i) { return i < changed; }));
    const double wrong = static_cast<double>(reported.size()) - right;
    sum.false_periods += wrong > 0.0 ? 1.0 : 0.0;
    if (changed > 0) sum.found += right / static_cast<double>(changed);
    if (!reported.empty()) sum.false_share += wrong / static_cast<double>(reported.size());
  }
  for (double* const value : {&sum.false_nights, &sum.false_periods, &sum.gross_nights, &sum.found, &sum.false_share})
    *value *= 100.0 / periods;
  return sum;
}

struct Change {
  const char* name;
  double step, ramp;  // deviations, and deviations a run
};
constexpr std::array<Change, 5> kChanges = {
    {{"step_1", 1.0, 0.0}, {"step_2", 2.0, 0.0}, {"step_3", 3.0, 0.0}, {"ramp_0.1", 0.0, 0.1}, {"ramp_0.5", 0.0, 0.5}}};

// Of figures that do not change.
const std::array<std::pair<const char*, ChartDraw>, 3> sound_figures = {
    {{"normal", normal}, {"largest", largest}, {"log_of_largest", log_of_largest}}};

void one_figure(FigureList& list, int draws, int n, unsigned& seed) {
  const std::string start = fmt::format("n{}_", n);
  for (const auto& [name, draw] : sound_figures) {
    Random random(++seed);
    list.add(fmt::format("{}false_{}", start, name), 100.0 * chart_found(draws, n, draw, 0.0, 0.0, random).share, "%");
  }
  for (const Change& change : kChanges) {
    Random random(++seed);
    const ChartFound result = chart_found(draws, n, normal, change.step, change.ramp, random);
    list.add(start + change.name, 100.0 * result.share, "%");
    list.add(fmt::format("{}{}_median", start, change.name), result.median, "runs");
  }
}

void whole_nights(FigureList& list, int periods, int n, unsigned& seed) {
  const std::string start = fmt::format("n{}_of_{}_", n, kNightFigures);
  for (const auto& [name, draw] : sound_figures) {
    Random random(++seed);
    const ChartNights result = chart_nights(periods, n, draw, 0, 0.0, random);
    list.add(fmt::format("{}false_nights_{}", start, name), result.false_nights, "%");
    list.add(fmt::format("{}false_periods_{}", start, name), result.false_periods, "%");
    list.add(fmt::format("{}gross_nights_{}", start, name), result.gross_nights, "%");
  }
  for (const std::size_t changed : {1U, 67U})
    for (const double step : {2.0, 3.0, 5.0}) {
      Random random(++seed);
      const ChartNights result = chart_nights(periods, n, normal, changed, step, random);
      list.add(fmt::format("{}{}_step_{:.0f}_found", start, changed, step), result.found, "%");
      list.add(fmt::format("{}{}_step_{:.0f}_false_share", start, changed, step), result.false_share, "%");
    }
}

}  // namespace

std::vector<Figure> benchmark_charts(int draws) {
  FigureList list("charts");
  unsigned seed = 0;
  for (const int n : {8, 20, 30}) {
    one_figure(list, draws, n, seed);
    whole_nights(list, std::max(1, draws / 100), n, seed);
  }
  return list.take();
}

}  // namespace tactbench::bench
