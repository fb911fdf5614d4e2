// Splits the inner branches of histories into folds for cross-validation.
#pragma once

#include <vector>

#include "analysis/identify/fit_data.h"

namespace tactbench::analysis {

// Branches by history. Of all folds together each inner branch is held once, the branches of the external loop never.
struct Fold {
  std::vector<std::vector<Branch>> kept, held;
};

// At most `most` folds, and no more than there are inner branches; none when there are fewer than two of these. Only
// the inputs and branches of `data` are used.
std::vector<Fold> folds_of(const FitData& data, int most = 5);

// `data` with other branches, those of each history.
FitData with_branches(FitData data, const std::vector<std::vector<Branch>>& branches);

}  // namespace tactbench::analysis
