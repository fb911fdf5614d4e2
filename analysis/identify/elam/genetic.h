// Identifies ELAM's parameters by a genetic algorithm as the paper does (section 5), as an alternative to the exact
// method of elam.h: for comparison, never the default. The algorithm is pagmo2's sga (Biscani, Izzo 2020), an
// optional component of a build.
#pragma once

#include <span>

#include "analysis/identify/elam/elam.h"

namespace tactbench::analysis {

bool has_genetic();  // this build has it
inline constexpr const char* kNoGenetic = "this build has no genetic algorithm: install libpagmo-dev and build again";

// J of Eq. (1) over all five parameters at once in the box of identify_elam: the unit cube in alpha_d, beta_d, the
// relative splits of ascending branches of length 0 and xu - x0, and beta_a. 50 individuals, 500 generations. The same
// seed gives the same fit. Throws as identify_elam does, and std::invalid_argument without the component.
ElamFit identify_elam_ga(const PatternCurve& ascending, const PatternCurve& descending,
                         std::span<const TaxelBranch> branches, const ElamOptions& options = {}, unsigned seed = 1);

}  // namespace tactbench::analysis
