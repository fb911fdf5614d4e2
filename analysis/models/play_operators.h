// Play operators, the elements of the Prandtl-Ishlinskii models (paper, section 3) and of the Preisach cells. Each is a
// function of the input and of its own last output; along a monotone way only the last input counts, so that a history
// may be sampled arbitrarily coarsely between two turns.
#pragma once

#include <algorithm>

namespace tactbench::analysis {

// Eq. (3): `left` and `right` are the envelopes at the input, non-decreasing in it. With max outside it also holds
// where left - r > right + r, which Eq. (3)'s condition excludes but both printed sets have at r = 0 [A14]: the
// operator is single-valued there. left = right = x is the classical play operator.
inline double generalized_play(double left, double right, double r, double before) {
  return std::max(left - r, std::min(right + r, before));
}

// Eq. (4), OSP: for inputs that do not fall below 0. Falls at once, rises r later.
inline double one_sided_play(double x, double r, double before) { return std::max(x - r, std::min(x, before)); }

}  // namespace tactbench::analysis
