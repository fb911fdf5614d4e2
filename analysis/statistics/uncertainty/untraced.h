// Why errors of a run relative to the pressure reference are not traceable.
#pragma once

#include <string>

#include "analysis/pressure_unit.h"

namespace tactbench::analysis {

// Overdue, or else beyond what the reference's certificate covers.
struct Untraced {
  std::string overdue_since = {};                // "2026-01-31"; empty: in date
  double run_low_psi = 0.0, run_high_psi = 0.0;  // levels of the run
  double low_psi = 0.0, high_psi = 0.0;          // covered
  bool below = false, above = false;             // where the run goes beyond
  bool corrected = false;                        // covered by a correction, of readings from ... to:
  double first_reading_psi = 0.0, last_reading_psi = 0.0;
  friend bool operator==(const Untraced&, const Untraced&) = default;
};

// "reference overdue since 2026-01-31"; "levels above 50 psi are not traceable: the run goes from 0 to 60 psi, the
// reference's certificate covers 0 to 50 psi".
std::string in_words(const Untraced& untraced, PressureUnit unit);

}  // namespace tactbench::analysis
