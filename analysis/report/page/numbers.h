// Formats numbers for people.
#pragma once

#include <string>

namespace tactbench::analysis {

// Decimals that give `expanded` two significant digits after rounding, 0..9; 3 for 0 or what is not finite (JCGM 100,
// 7.2.6).
int gum_decimals(double expanded);
// `value` rounded to the last significant digit of `expanded`: 106 has two significant digits as 110, so that its value
// is rounded to tens.
double rounded_beside(double value, double expanded);
// Half to even, U+2212 for a minus, no sign for zero, "–" for what is not finite.
std::string fixed_text(double value, int digits);
std::string two_digits_text(double expanded);

}  // namespace tactbench::analysis
