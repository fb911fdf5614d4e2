// Branches, repeats brought to common pressures, and the external loop: Dataset -> what identification fits.
#pragma once

#include <span>
#include <vector>

#include "analysis/dataset.h"

namespace tactbench::analysis {

// A monotone run of steps between two turning points (indices into a sequence's steps, both included).
struct Branch {
  int first = 0;
  int last = 0;
  bool ascending = true;
};

// Splits inputs into branches; equal samples keep the last direction [A8]. A turn counts once x has gone back by more
// than `tolerance` (0 for commanded inputs; measured ones carry noise).
std::vector<Branch> branches_along(std::span<const double> x, double tolerance = 0.0);

// The mean of a sequence's repeats on the set-point grid: outputs moved there by local slope x (reference -
// set-point) of their own branch (contract.md, "Which pressure").
struct CommonSequence {
  std::vector<double> pressure_psi;  // steps: set-points
  std::vector<double> volts;         // steps x taxels
  std::vector<Branch> branches;
};

struct CommonOptions {
  bool move_to_setpoint = true;  // false: take outputs as they are at the mean measured reference (--input measured)
  int first_repeat = 0;
  int last_repeat = -1;  // -1: the last
};

CommonSequence bring_to_common(const SequenceData& sequence, int taxels, const CommonOptions& options = {});

// External loop of every taxel on the common grid x0..xu: mean of all complete full-range sweeps.
struct ExternalLoop {
  std::vector<double> pressure_psi;  // n grid points, ascending
  std::vector<double> ascending_v;   // n x taxels
  std::vector<double> descending_v;  // n x taxels
};

// Throws AnalysisError TB-ANALYSIS-NO-LOOP when no full sweep up or down is there.
ExternalLoop external_loop(std::span<const CommonSequence> sequences, int taxels);

}  // namespace tactbench::analysis
