#include "analysis/identify/folds.h"

#include <algorithm>

namespace tactbench::analysis {

std::vector<Fold> folds_of(const FitData& data, int most) {
  const double low = data.ascending.x().front(), high = data.ascending.x().back(), near = 0.01 * (high - low);
  const auto inner = [&](const History& history, const Branch& branch) {
    const double from = history.x[static_cast<std::size_t>(branch.first)];
    return branch.ascending ? from - low > near : high - from > near;
  };
  int count = 0;
  for (const History& history : data.histories)
    count += static_cast<int>(
        std::ranges::count_if(history.branches, [&](const Branch& branch) { return inner(history, branch); }));
  if (count < 2) return {};
  const int number = std::min(most, count);
  std::vector<Fold> folds;
  for (int f = 0; f < number; ++f) {
    Fold& fold = folds.emplace_back();
    int seen = 0;
    for (const History& history : data.histories) {
      std::vector<Branch>&kept = fold.kept.emplace_back(), &held = fold.held.emplace_back();
      for (const Branch& branch : history.branches)
        (inner(history, branch) && seen++ % number == f ? held : kept).push_back(branch);
    }
  }
  return folds;
}

FitData with_branches(FitData data, const std::vector<std::vector<Branch>>& branches) {
  for (std::size_t h = 0; h < data.histories.size(); ++h) data.histories[h].branches = branches.at(h);
  return data;
}

}  // namespace tactbench::analysis
