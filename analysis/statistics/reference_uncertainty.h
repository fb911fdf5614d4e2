// What is known of the pressure reference's own error, from the calibration kept with the run's devices.
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::analysis {

struct ReferenceUncertainty {
  std::string certificate, due;  // as the bench file states them; due: YYYY-MM-DD; empty: not stated
  bool independent = false;      // false: the regulator's feedback stands in
  bool overdue = false;          // the run began after the due date
  // Certificate: U (psi, with coverage factor k) at readings, rising; empty: none.
  std::vector<double> reading_psi, expanded_psi;
  double coverage_factor = 2.0;
  double drift_psi = 0.0;       // limit of the change until the due date; 0: not stated
  double resolution_psi = 0.0;  // one digit or one converter step; 0: not known
  // Why a contribution is not assessed; empty where it is.
  std::string certificate_missing, drift_missing, resolution_missing;

  // u(p) = U(p) / k in psi (JCGM 100, 4.3.3), between the certificate's points linear, beyond them the last one's.
  [[nodiscard]] double certificate_u(double pressure_psi) const;
  [[nodiscard]] double largest_certificate_u() const;
};

// From the device of role "pressure reference" and the analog module that reads it. Never throws: what cannot be read
// is not assessed.
ReferenceUncertainty reference_uncertainty(const db::RunRecord& run);
// Volts a count of the run's tactile scanner; 0 where that is not kept.
double scanner_step_v(const db::RunRecord& run);

}  // namespace tactbench::analysis
