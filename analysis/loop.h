// Branches, repeats interpolated to common pressures, and the external loop: Dataset -> input of identification.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "analysis/dataset.h"

namespace tactbench::analysis {

// Set-points and levels that lie nearer than this are one: recipes, models and limits spell the same level differently.
inline constexpr double kSameLevelPsi = 1e-6;
// A level that people type means the nearest one that was measured, this near: theirs is rounded, or of another unit.
inline constexpr double kTypedLevelPsi = 0.01;
inline bool same_level(double a_psi, double b_psi) { return std::abs(a_psi - b_psi) < kSameLevelPsi; }

// A monotone run of steps between two turning points (indices into a sequence's steps, both included).
struct Branch {
  int first = 0;
  int last = 0;
  bool ascending = true;
};

// Splits inputs into branches; equal samples keep the last direction [A8]. A turn counts once x has gone back by more
// than `tolerance` (0 for commanded inputs; measured ones carry noise).
std::vector<Branch> branches_along(std::span<const double> x, double tolerance = 0.0);

// One sequence as a table: a value of each taxel at each step. Volts, psi or a share, as the table's owner states.
struct TaxelTable {
  std::vector<double> pressure_psi;  // steps: set-points
  std::vector<double> values;        // steps x taxels
  std::vector<Branch> branches;
};

struct RepeatOptions {
  bool move_to_setpoint = true;  // false: outputs as they came, pressures the mean measured reference
  int first_repeat = 0;
  int last_repeat = -1;  // -1: the last
};

// The mean of a sequence's repeats, in volts, on the set-point grid: outputs moved there by the local slope of their
// own branch x (set-point - reference) [A19].
TaxelTable average_repeats(const SequenceData& sequence, int taxels, const RepeatOptions& options = {});

// External loop of every taxel on the common grid x0..xu: mean of all complete full-range sweeps. Values in the unit of
// the tables that it is made of.
struct ExternalLoop {
  std::vector<double> pressure_psi;  // n grid points, ascending
  std::vector<double> ascending;     // n x taxels
  std::vector<double> descending;    // n x taxels
  double left_out = 0.0;             // share of the inputs that lies beyond each end
  bool joined = false;               // a sweep is made of the last branch and the first
};

// A sweep is full when it begins and ends within 1 % of the span from the ends of the inputs, or within `turn` (0 for
// commanded inputs). Of measured ones the ends are the extremes or, where no full sweeps up and down lie between these,
// the nearest percentiles up to the second between which they do; and where a sequence ends as it began, its last
// branch and its first are one sweep if no other is there. Throws AnalysisError TB-ANALYSIS-NO-LOOP when no full sweep
// up or down is there.
ExternalLoop external_loop(std::span<const TaxelTable> sequences, int taxels, double turn = 0.0);

}  // namespace tactbench::analysis
