// A fit as the store keeps it, and two such beside each other: what `verify` compares. Paper's ELAM on all sequences is
// kept as rows, every other model as its document. Stored rows and
// rows recomputed from the raw frames are equal bit for bit on the same build and class of processor; elsewhere
// numbers may differ by kRelativeTolerance.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "db/record.h"

namespace tactbench::analysis {

struct FitRows {
  db::FitRecord fit;                       // without number, program version and time
  std::vector<db::FitTaxelRecord> taxels;  // the mean taxel first; none: kept as a document
};
FitRows rows_of(const SensorModel& fit);
// The model that the rows hold. Throws AnalysisError TB-MODEL-STORED.
SensorModel model_from_rows(const FitRows& rows);

// Who made a stored fit, as store_fit was told; empty: not kept (older stores).
std::string made_by(const db::FitRecord& fit);
// Options that a fit in rows was made with. Throws AnalysisError TB-MODEL-STORED when they cannot be read.
IdentifyOptions options_of(const db::FitRecord& fit);

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
