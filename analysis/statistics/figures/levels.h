// The figures of each level of the external loop (Tables 6, 7) and their averages.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

// Rows (levels or steps) of a rows x taxels table, the fitted taxels only.
class Fitted {
 public:
  explicit Fitted(const SensorModel& fit);
  [[nodiscard]] std::vector<double> row(const std::vector<double>& table, std::size_t row) const;
  // The whole row, taxels that are not fitted as NaN when `only_fitted`.
  [[nodiscard]] std::vector<double> frame(const std::vector<double>& table, std::size_t row, bool only_fitted) const;
  [[nodiscard]] const std::vector<std::size_t>& taxels() const { return taxels_; }
  [[nodiscard]] std::size_t width() const { return width_; }

 private:
  std::size_t width_;
  std::vector<std::size_t> taxels_;
};

// Fills in `levels` and what is averaged over them.
void gather_levels(Evaluation& evaluation, const CompensatedStreams& streams, const Fitted& fitted);

// Classifies each step of a sequence: on a full sweep of the range or on an inner branch, up or down.

struct StepKind {
  bool full = false;  // its branch goes from one end of the range to the other, within 1 % of it
  bool up = true;     // the step was reached from below
  int branch = 0;     // of the sequence, from 0; a turning point belongs to the branch that ends there
};

// Of each step, by the set-points of the first repeat. low < high: the range, psi. A sequence of equal set-points is
// one branch up that is not full.
std::vector<StepKind> step_kinds(const SequenceData& sequence, double low, double high);

}  // namespace tactbench::analysis
