// Branches, repeats interpolated to common pressures, and the external loop: Dataset -> input of identification.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "analysis/dataset.h"

namespace tactbench::analysis {

// Set-points and levels closer than this are the same level: recipes, models and limits may write it with different
// digits.
inline constexpr double kSameLevelPsi = 1e-6;
// A typed level means the nearest measured level within this distance: it may be rounded, or converted from another
// unit.
inline constexpr double kTypedLevelPsi = 0.01;
inline bool same_level(double a_psi, double b_psi) { return std::abs(a_psi - b_psi) < kSameLevelPsi; }

// A monotone run of steps between two turning points (indices into a sequence's steps, both inclusive).
struct Branch {
  int first = 0;
  int last = 0;
  bool ascending = true;
};

// Splits inputs into branches; equal samples keep the last direction [A8]. A turn counts once x has gone back by more
// than `tolerance` (0 for commanded inputs; measured ones carry noise).
std::vector<Branch> branches_along(std::span<const double> x, double tolerance = 0.0);

// One sequence as a table: a value of each taxel at each step, in volts, psi or a share, as documented by the user of
// the table.
struct TaxelTable {
  std::vector<double> pressure_psi;  // steps: set-points
  std::vector<double> values;        // steps x taxels
  std::vector<Branch> branches;
};

struct RepeatOptions {
  bool move_to_setpoint = true;  // false: outputs unchanged, pressures from the mean measured reference
  int first_repeat = 0;
  int last_repeat = -1;  // -1: the last
};

// The mean of a sequence's repeats, in volts, on the set-point grid: outputs are corrected by the local slope of their
// branch x (set-point - reference) [A19].
TaxelTable average_repeats(const SequenceData& sequence, int taxels, const RepeatOptions& options = {});

// External loop of every taxel on the common grid x0..xu: mean of all complete full-range sweeps. Values in the unit of
// the input tables.
struct ExternalLoop {
  std::vector<double> pressure_psi;  // n grid points, ascending
  std::vector<double> ascending;     // n x taxels
  std::vector<double> descending;    // n x taxels
  double left_out = 0.0;             // share of the inputs beyond each end
  bool joined = false;               // a sweep was joined from the last and the first branch
};

// A sweep is full when it begins and ends within 1 % of the span from the ends of the inputs, or within `turn` (0 for
// commanded inputs). For measured inputs the ends are the extremes or, if no full sweeps up and down lie between these,
// the outermost percentiles (up to the second) between which they do. If a sequence ends where it began and has no
// other full sweep, its last and first branch form one. Throws AnalysisError TB-ANALYSIS-NO-LOOP if there is no full
// sweep up or down.
ExternalLoop external_loop(std::span<const TaxelTable> sequences, int taxels, double turn = 0.0);

}  // namespace tactbench::analysis
