// Classifies each step of a sequence: on a full sweep of the range or on an inner branch, up or down.
#pragma once

#include <vector>

#include "analysis/dataset.h"

namespace tactbench::analysis {

struct StepKind {
  bool full = false;  // its branch goes from one end of the range to the other, within 1 % of it
  bool up = true;     // the step was reached from below
  int branch = 0;     // of the sequence, from 0; a turning point belongs to the branch that ends there
};

// Of each step, by the set-points of the first repeat. low < high: the range, psi. A sequence of equal set-points is
// one branch up that is not full.
std::vector<StepKind> step_kinds(const SequenceData& sequence, double low, double high);

}  // namespace tactbench::analysis
