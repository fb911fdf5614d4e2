// Identification of the five ELAM parameters of a taxel from its branches, exact and deterministic: with measured
// turning points J of Eq. (1) separates into a descending and an ascending half.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/models/elam.h"

namespace tactbench::analysis {

// One taxel's inner and outer branches on the common grid, for fitting and scoring.
struct TaxelBranch {
  bool ascending = true;
  std::vector<double> pressure_psi;  // from the turning point on
  std::vector<double> volts;
};

struct ElamFit {
  ElamModel model;
  double j_v2 = 0.0;          // Eq. (1), descending + ascending
  double mean_error_v = 0.0;  // Eq. (49)
  double max_error_v = 0.0;
  double full_scale_v = 0.0;  // largest output of the external loop, without sign
  unsigned at_bound = 0;      // bit i: parameter i at a bound; alpha_a1: the split of the longest branch is
  unsigned undetermined = 0;  // bit i, likewise: the data leave it open (elam_determined.h); not stored
};

// Fits alpha_d, beta_d on descending branches and the rest on ascending ones [A18]. Bounds: alpha_d, beta_d, beta_a and
// the relative split alpha_a1 L + alpha_a0 at L = 0 and L = xu - x0 in [0, 1]. Inner branches start at their measured
// turning point [A9], external ones at (x0, y0) or (xu, yu); a branch's first sample is its turning point and is not
// scored. `settle`: what the data leave open is taken near the pattern (elam_determined.h). Throws
// std::invalid_argument on malformed branches or patterns that do not meet.
ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options = {}, bool settle = true);

unsigned bounds_met(const ElamModel& model);  // ElamFit::at_bound of it

// Of the parameters that `fit` says the data leave open.
std::vector<std::string> undetermined_names(const ElamFit& fit);

}  // namespace tactbench::analysis
