// A value beside its uncertainty as the GUM writes them (JCGM 100, 7.2.6): U to two significant digits, the value to
// the same decimal place.
#pragma once

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

// Decimals that give `expanded` two significant digits after rounding, 0..9; 3 for 0 or what is not finite.
int gum_decimals(double expanded);
html::Text gum_uncertainty(double expanded);            // "0.34"
html::Markup gum_value(double value, double expanded);  // "−0.12 ± 0.34"
// In the page's unit, the other one behind it, each with two digits: "0.62 kPa (0.090 psi)".
html::Markup gum_pressure(double expanded_psi, PressureUnit unit);
html::Markup gum_pressure(double value_psi, double expanded_psi,
                          PressureUnit unit);  // "−0.83 ± 2.3", the figures alone
// The value alone, at the decimal place of its U in each unit: "6.23 kPa (0.903 psi)"; and with it: "6.23 ± 0.92 kPa
// (0.90 ± 0.13 psi)".
html::Markup gum_pressure_value(double value_psi, double expanded_psi, PressureUnit unit);
html::Markup gum_pressure_stated(double value_psi, double expanded_psi, PressureUnit unit);
html::Text gum_degrees(double dof);  // "17", cut to a whole number (G.4.1); "∞"

}  // namespace tactbench::analysis
