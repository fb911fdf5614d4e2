// A history's inner branches dealt into parts, for fits that are judged on what they were not made from.
#pragma once

#include <vector>

#include "analysis/identify/fit_data.h"

namespace tactbench::analysis {

// Branches by history. Of all folds together each inner branch is held once, the branches of the external loop never.
struct Fold {
  std::vector<std::vector<Branch>> kept, held;
};

// As many as `most`, or as there are inner branches; none when there are fewer than two of these. Only the inputs and
// branches of `data` are looked at.
std::vector<Fold> folds_of(const FitData& data, int most = 5);

// `data` with other branches, those of each history.
FitData with_branches(FitData data, const std::vector<std::vector<Branch>>& branches);

}  // namespace tactbench::analysis
