// The samples of all histories in one sequence, checked once, and the operations on them that every identification
// shares.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "analysis/identify/fit_models.h"

namespace tactbench::analysis {

// A history that does not begin at the lowest input was reached from there by one rise, or from the highest input by
// one fall where its first branch falls. Between two turning points only the way from the branch's first sample counts:
// a measured input that steps back within a branch makes no turn.
struct FitSamples {
  struct Part {
    bool ascending = true;
    bool opens_history = false;  // the model is virgin before it,
    bool from_top = false;       // or has come to the highest input
    std::size_t first = 0, last = 0;
  };
  // Throws std::invalid_argument when data are missing, not finite, or of one direction only and not `one_way`.
  explicit FitSamples(const FitData& data, bool one_way = false);

  double x_low = 0.0, x_high = 0.0;  // of the external loop
  std::vector<double> x;             // clamped to it
  std::vector<Part> parts;           // branches
  std::vector<std::size_t> scored;   // all samples of branches but the first of each
  std::vector<std::size_t> fitted;   // about kFittedSamples of those, evenly chosen, when there are more

  // The outputs in the same order. Throws std::invalid_argument when the inputs or branches of `data` are others.
  [[nodiscard]] std::vector<double> outputs(const FitData& data) const;

 private:
  std::vector<std::vector<double>> inputs_;
  std::vector<std::vector<Branch>> branches_;
};

// Regressions look at no more samples than this: longer histories are thinned evenly, in step with no period of them.
// Errors are over all samples.
inline constexpr std::size_t kFittedSamples = 20000;
std::vector<std::size_t> thinned(const std::vector<std::size_t>& samples, std::size_t most);

// Calls visit(sample, state) for each scored sample with `state` as it was at the start of the sample's branch.
// State: a value with move(x).
template <class State, class Visit>
void walk_branches(const FitSamples& samples, const State& virgin, const Visit& visit) {
  State state = virgin;
  std::size_t last = 0;
  for (const FitSamples::Part& part : samples.parts) {
    if (part.opens_history) state = virgin;
    if (part.from_top) state.move(samples.x_high);
    // What lies between two branches of a history is walked, too.
    for (std::size_t i = part.opens_history ? part.first : std::min(last + 1, part.first); i <= part.first; ++i)
      state.move(samples.x[i]);
    for (std::size_t i = part.first + 1; i <= part.last; ++i) visit(i, state);
    state.move(samples.x[last = part.last]);
  }
}

// Fill in the figures of a fit: from the errors of the scored samples, or walking fit.model along the data.
void score(ModelFit& fit, const FitData& data, std::span<const double> errors);
void score_walk(ModelFit& fit, const FitData& data, const FitSamples& samples, std::span<const double> measured,
                bool free_run);

// Splits the inner branches of histories into folds for cross-validation.

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
