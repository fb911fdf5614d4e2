// Stored fits and verdicts beside what was recomputed from the raw frames: what `verify` compares. They are equal bit
// for bit on the same build and class of processor; elsewhere numbers may differ by kRelativeTolerance.
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::analysis {

inline constexpr double kRelativeTolerance = 1e-12;

// |a - b| <= tolerance x max(|a|, |b|); any two NaN are equal, and so are 0.0 and -0.0.
bool same_number(double a, double b, double tolerance);

// In words, the first thing that differs; empty: nothing. Fits: two documents (model_document.h). Their numbers, with
// tolerance 0, are compared by their bits.
std::string first_difference(const std::string& stored, const std::string& recomputed, double tolerance);
std::string first_difference(const std::vector<db::VerdictRecord>& stored,
                             const std::vector<db::VerdictRecord>& recomputed, double tolerance, bool with_u = true);

}  // namespace tactbench::analysis
