// A value beside its uncertainty as the GUM writes them (JCGM 100, 7.2.6): U to two significant digits, the value to
// the same decimal place.
#pragma once

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

// Decimals that give `expanded` two significant digits after rounding, 0..9; 3 for 0 or what is not finite.
int gum_decimals(double expanded);
html::Text gum_uncertainty(double expanded);            // "0.34"
html::Markup gum_value(double value, double expanded);  // "−0.12 ± 0.34"
html::Text gum_degrees(double dof);                     // "17", cut to a whole number (G.4.1); "∞"

}  // namespace tactbench::analysis
