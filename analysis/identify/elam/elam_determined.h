// Finds which of ELAM's parameters the samples determine, and chooses the values of the others.
#pragma once

#include <span>

#include "analysis/identify/elam/elam_samples.h"

namespace tactbench::analysis {

// Looks at one direction of a model that was fitted to `curves`; `constant` as in ElamSamples. A parameter is left open
// when its standard error, from the residuals and Gauss-Newton's Hessian, is above that of a value drawn anywhere
// between its bounds (1 / sqrt 12), or when J changes by less than a sample's variance as the split runs so far along
// the pattern either way. Returns the open ones, bits as ElamFit::at_bound, and moves the model:
// - to the pattern's own split at the middle of the input range, where its J is above the best by chance alone (95 %)
//   and a parameter is open there: so with external branches alone, whose J is the same along the whole pattern;
// - else along the open directions as near to it as J stays the same within 1e-7.
// A model without open parameters stays as it is.
unsigned settle_undetermined(ElamModel& model, std::span<const CurveSamples> curves, double constant, bool ascending);

}  // namespace tactbench::analysis
