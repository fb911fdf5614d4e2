// What share of corrected readings lies within the report's own U of the truth, on simulated sensors: the plant's
// pressure, which neither models nor budgets see.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/benchmarks/figure.h"
#include "bench/benchmarks/simulated_run.h"

namespace tactbench::bench {

struct CoverageOptions {
  std::vector<unsigned> sensor_seeds;
  bool harsh = true, paper = true;         // specimens
  bool production = true, table_1 = true;  // calibrations
  bool elam = true, dynamic = true;        // models
};

// For each specimen, calibration, model and condition of use: coverage in % of (taxel, frame) pairs, the median U and
// the half-width of the smallest interval about 0 that covers 95 % of the same errors; or how many sensors the report
// calls U not valid for. Runs are made in `folder`.
std::vector<Figure> benchmark_coverage(const CoverageOptions& options, const std::string& folder,
                                       const Simulate& simulate = simulate_run);

// How a sensor is used after its calibration.
struct SensorUse {
  std::string name;
  SimulatedRun made;         // a run of that use: random reversals, or without recipes the sequences of the calibration
  bool full_sweeps = false;  // of its frames those on full sweeps count, else those on inner branches
};
std::vector<SensorUse> coverage_uses();

struct Covered {
  double inside = 0.0, not_valid = 0.0;  // pairs; sensors of which the report says that U does not cover the use
  std::vector<double> errors, expanded;  // of each pair
};
using Coverages = std::map<std::string, Covered>;  // by specimen, calibration, model and use
std::vector<Figure> figures_of(const Coverages& coverages);

// The readings of a run by that fit, in the order of the taxels, against the pressures that are known and what is
// stated of them: those on full sweeps, or those on inner branches.
void add_errors(const KnownRun& run, const analysis::SensorModel& fit, const analysis::ConditionUncertainty& stated,
                bool full_sweeps, Covered& covered);

}  // namespace tactbench::bench
