// Compensates every stored frame of a dataset in time order; the figures of each level of the external loop (Tables 6,
// 7) and their averages.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/workers.h"

namespace tactbench::analysis {

// One sequence of a dataset, the mean of its repeats: tables on the set-point grid.
struct CompensatedSequence {
  TaxelTable raw;                     // V
  TaxelTable pressure;                // psi: estimates, moved to the set-points
  TaxelTable flat;                    // share of the repeats that were flagged
  std::vector<double> unmoved_psi;    // steps x taxels: estimates as they came
  std::vector<double> reference_psi;  // steps
};

// Sums of one taxel over all its frames.
struct TaxelErrors {
  double sum_psi = 0.0, max_psi = 0.0;                        // |estimate - reference|
  double max_at_psi = 0.0;                                    // the reference at max_psi
  double sum_observable_psi = 0.0, max_observable_psi = 0.0;  // without flat ones
  int frames = 0, observable = 0;
};

struct CompensatedStreams {
  std::vector<CompensatedSequence> sequences;
  std::vector<TaxelErrors> errors;  // taxels; zero frames where not fitted
};

// Each fitted taxel's stored samples through its compensator in time order (stream_samples). A model with lag and creep
// is given the times, and what of them was conditioning. `take_of(taxel)` returns the function to call with (sequence,
// repeat, step, Compensated), in that taxel's order. Threads by taxel.
template <class TakeOf>
void compensate_in_order(const Dataset& dataset, const SensorModel& fit, int threads, const TakeOf& take_of) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  for_each_index(width, threads, [&](std::size_t taxel) {
    const ModelTaxel& own = fit.taxels[taxel];
    if (!own.fitted()) return;
    const auto stream = compensator_of(fit, own);
    stream_samples(
        dataset, *stream, [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * width + taxel]; },
        take_of(taxel));
  });
}

CompensatedStreams compensate_all(const Dataset& dataset, const SensorModel& fit, int threads);

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
