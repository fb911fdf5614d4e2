// Every stored frame compensated in time order: what the figures of an Evaluation are gathered from.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/identify.h"
#include "analysis/loop.h"

namespace tactbench::analysis {

// One sequence of a dataset, the mean of its repeats; steps x taxels like CommonSequence::volts.
struct CompensatedSequence {
  CommonSequence raw;                 // on the set-point grid
  CommonSequence pressure;            // estimates, moved to the set-points
  CommonSequence flat;                // share of the repeats that were flagged
  std::vector<double> unmoved_psi;    // estimates as they came
  std::vector<double> reference_psi;  // steps
};

// Sums of one taxel over all its frames.
struct TaxelErrors {
  double sum_psi = 0.0, max_psi = 0.0;                        // |estimate - reference|
  double sum_observable_psi = 0.0, max_observable_psi = 0.0;  // without flat ones
  int frames = 0, observable = 0;
};

struct CompensatedStreams {
  std::vector<CompensatedSequence> sequences;
  std::vector<TaxelErrors> errors;  // taxels; zero frames where not fitted
};

// State carries over from repeat to repeat and from sequence to sequence. Threads by taxel.
CompensatedStreams compensate_all(const Dataset& dataset, const ArrayFit& fit, int threads);

}  // namespace tactbench::analysis
