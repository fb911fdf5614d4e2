// The share of corrected readings within the report's U of the true value, by kind of history, on simulated
// sensors that were calibrated as `calibrate` does it. The truth is the plant's pressure, which neither models nor U
// see. U is counted on one run of `verification`; further runs of it, whose histories are drawn anew, are held against
// it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/empirical_errors.h"
#include "bench/config/plant_options.h"

namespace tactbench::bench {

struct CoverageOptions {
  std::uint64_t seed = 0;  // of sensors, instruments, noise and histories
  std::vector<SpecimenKind> specimens = {SpecimenKind::kPaper, SpecimenKind::kHarsh, SpecimenKind::kFoam};
  int sensors = 12, further = 3;  // of each specimen; runs of verification that are held against U
  std::vector<std::string> recipes = {"production"};
  std::string held_out = "verification";
};

// Of one sensor and kind.
struct CoveredKind {
  analysis::UseCondition kind = analysis::UseCondition::kFullSweeps;
  std::string not_valid;  // empty: U is stated
  double inside = 0.0, readings = 0.0;
  double factor = 0.0, median_psi = 0.0;
  [[nodiscard]] double percent() const { return 100.0 * inside / readings; }
};
struct CoveredSensor {
  unsigned seed = 0;
  double reference_off = 0.0;  // what the reference errs by on average in the calibration, over its own u
  double minutes = 0.0;        // process time of both runs
  std::vector<CoveredKind> kinds;
};
// Over the sensors for which U is stated.
struct CoverageOfKind {
  analysis::UseCondition kind = analysis::UseCondition::kFullSweeps;
  int stated = 0, outside = 0;  // sensors; those with less than 90 or more than 99 % inside
  double percent = 0.0, least = 0.0, most = 0.0;
  double median_u_psi = 0.0, half_width_psi = 0.0;  // half-width: covers 95 % of the same errors
};
struct CoverageOfSpecimen {
  std::string specimen;
  std::vector<CoveredSensor> sensors;
  std::vector<CoverageOfKind> kinds;
};

// Runs are made in `folder`. Says on stderr how far it is. Throws what carrying out a run throws.
std::vector<CoverageOfSpecimen> study_coverage(const CoverageOptions& options, const std::string& folder);
std::string markdown_of(const std::vector<CoverageOfSpecimen>& study);

}  // namespace tactbench::bench
