// Whether a sequence's first repeat is like the others: a sensor that was never loaded, or rested long, often is not.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/loop.h"

namespace tactbench::analysis {

// Outputs of the mean of some taxels, moved to the set-points; the first repeat against the mean of the others.
struct RepeatDrift {
  std::string sequence;
  double shift_v = 0.0;        // mean over the steps of first - others
  double uncertainty_v = 0.0;  // standard deviation of such a shift, from the others among themselves
  double rms_v = 0.0;          // root mean square over the steps of first - others
  double others_rms_v = 0.0;   // the largest such value of another repeat against the rest of the others
  bool differs = false;        // |shift| above 3 uncertainties, or rms above twice the others'
};

// One per sequence of three or more repeats at the pace of the first: with two none could say which one drifted. To
// leave the first one out of a fit: RepeatOptions::first_repeat.
std::vector<RepeatDrift> repeat_drifts(const Dataset& dataset, std::span<const std::size_t> taxels,
                                       const RepeatOptions& options);

}  // namespace tactbench::analysis
