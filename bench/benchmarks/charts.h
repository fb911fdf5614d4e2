// False alarms and power of the charts of figures over 60 runs, on figures drawn at random.
#pragma once

#include <cstddef>
#include <functional>
#include <random>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// One figure, `draws` histories a case (standard error at most 0.5 % / sqrt(draws / 10000)): false alarms, and steps
// and ramps found, with the median run. Nights of 671 figures, draws / 100 periods a case: nights and periods of 60
// nights with a false report, figures that shifted and are found, the share of false ones among those reported.
// Baselines of 8, 20 and 30 runs. The truth comes from random numbers alone; seeds are the case's number.
inline constexpr std::size_t kNightFigures = 671;  // of a night of the shipped suite
std::vector<Figure> benchmark_charts(int draws, std::size_t night_figures = kNightFigures);

// A figure of one run.
using ChartDraw = std::function<double(std::mt19937_64& random)>;

struct ChartFound {
  double share = 0.0;   // of histories with an alarm in 60 runs
  double median = 0.0;  // run of the alarm, where there is one
};
// `draws` histories of one figure, each with a baseline of `start_up` runs; then every run is higher by `step`, and by
// `ramp` more with each run.
ChartFound chart_found(int draws, int start_up, const ChartDraw& draw, double step, double ramp,
                       std::mt19937_64& random);

// Percent.
struct ChartNights {
  double false_nights = 0.0, false_periods = 0.0;  // with a figure reported that did not change
  double gross_nights = 0.0;                       // nights with such a figure outside its wide band
  double found = 0.0;                              // of the changed figures, in a period
  double false_share = 0.0;                        // of the figures reported in a period, mean over the periods
};
// Periods of 60 nights of so many figures. `changed` of the figures step by `step` after the baseline.
ChartNights chart_nights(int periods, int start_up, const ChartDraw& draw, std::size_t changed, double step,
                         std::mt19937_64& random, std::size_t night_figures = kNightFigures);

}  // namespace tactbench::bench
