// Compares stored fits and verdicts with those recomputed from the raw frames, for `verify`. They are equal bit for bit
// on the same build and class of processor; elsewhere numbers may differ by kRelativeTolerance.
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::analysis {

inline constexpr double kRelativeTolerance = 1e-12;

// |a - b| <= tolerance x max(|a|, |b|); any two NaN are equal, and so are 0.0 and -0.0.
bool same_number(double a, double b, double tolerance);

// Text of the first difference; empty: none. Fits: two documents (model_document.h). With tolerance 0 their numbers are
// compared bit by bit.
std::string first_difference(const std::string& stored, const std::string& recomputed, double tolerance);
std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance, bool with_u = true);

}  // namespace tactbench::analysis
