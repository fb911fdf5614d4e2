// Compensates every stored frame of a dataset in time order; the figures of an Evaluation are computed from the result.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/compensators.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
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

}  // namespace tactbench::analysis
