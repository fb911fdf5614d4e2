// Names of criteria for people, by VIM and the guides on conformity; the keys of limits files, stores and JSON stay as
// they are ("mean_compensation_error").
#pragma once

#include <string>

#include "analysis/pressure_unit.h"

namespace tactbench::analysis {

// "mean absolute error", "non-uniformity"; an unknown one with blanks in place of its underscores.
std::string criterion_in_words(const std::string& criterion);
// "40 psi up" -> "275.8 kPa increasing"; what names no pressure stays as it is.
std::string scope_in_words(const std::string& scope, PressureUnit unit);
// With the other unit behind, for documents: "275.8 kPa (40 psi) increasing".
std::string scope_in_both_units(const std::string& scope, PressureUnit unit);

}  // namespace tactbench::analysis
