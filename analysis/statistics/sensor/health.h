// Dead, stuck, saturated, unmodelled and noisy taxels of a run, by stated criteria: Dataset -> findings of the report.
#pragma once

#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

struct HealthOptions {
  double dead_v = kDeadV;                            // an output that moves less is dead (near 0 V) or stuck
  double noisy_factor = 4.0;                         // noise above this many times the median taxel's is noisy
  double swap_margin = 0.2, swap_correlation = 0.8;  // by which lines fit better in each other's place, and how well
};

struct TaxelHealth {
  int taxel = 0;          // row * columns + column
  std::string state;      // dead | stuck | saturated | noisy | unfit; a taxel may be listed twice
  std::string reason;     // with the figure that decided, for people
  bool excluded = false;  // left out of every figure of models and compensation
};

// Lines whose responses fit better the other way round than at the last good seating.
struct SwappedLines {
  bool rows = true;  // else columns
  int first = 0, second = 0;
  double as_is = 0.0, exchanged = 0.0;  // the lower of the two lines' correlations
};

struct Health {
  HealthOptions options;
  int rows = 0, columns = 0;
  bool loaded = true;  // false: the run pressed on a part of the array, so a silent taxel need not be dead
  std::vector<double> low_v, high_v;  // taxels: extremes of all samples
  std::vector<double> noise_v;        // taxels, of one sample; empty where single scans give none
  double median_noise_v = 0.0;        // NaN without noise
  std::vector<TaxelHealth> findings;  // by taxel
  bool swaps_assessed = false;
  std::vector<SwappedLines> swaps;
  [[nodiscard]] int count(const std::string& state) const;
};

// `fit`: of the run, whose states win; without taxels: decided from the samples by the same thresholds. `loaded` as
// above. Throws std::invalid_argument when the fit has other taxels than the dataset.
Health health_of(const Dataset& dataset, const SensorModel& fit, bool loaded, const HealthOptions& options = {});

// Pairs of rows and of columns of 8 taxels or more that changed places, each the other's best fit, between two frames
// of responses (rows x columns, row-major). A taxel that is not finite in one frame is left out: it shows nothing about
// its line.
std::vector<SwappedLines> swapped_lines(int rows, int columns, const std::vector<double>& now,
                                        const std::vector<double>& before, const HealthOptions& options = {});

}  // namespace tactbench::analysis
