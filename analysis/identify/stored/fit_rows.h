// A fit as the rows that the store keeps, and two such sets beside each other: what `verify` compares. Stored rows and
// rows recomputed from the raw frames are equal bit for bit on the same build and class of processor; elsewhere
// numbers may differ by kRelativeTolerance.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/elam/identify.h"

namespace tactbench::analysis {

struct FitRows {
  db::FitRecord fit;                       // without number, program version and time
  std::vector<db::FitTaxelRecord> taxels;  // the mean taxel first
};
FitRows rows_of(const ArrayFit& fit);

// Who made a stored fit, as store_fit was told; empty: not kept (older stores).
std::string made_by(const db::FitRecord& fit);
// Options that a stored fit was made with. Throws AnalysisError TB-MODEL-STORED when they cannot be read.
ElamOptions options_of(const db::FitRecord& fit);

inline constexpr double kRelativeTolerance = 1e-12;

// Equal bits (any two NaN are equal, 0.0 and -0.0 as well: SQLite does not tell them apart), or, with a tolerance above
// 0, |a - b| <= tolerance x max(|a|, |b|).
bool same_number(double a, double b, double tolerance);

// In words, the first thing that differs between what is stored and what was recomputed; empty: nothing. tolerance 0:
// bit for bit.
std::string first_difference(const FitRows& stored, const FitRows& recomputed, double tolerance);
std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance);

}  // namespace tactbench::analysis
