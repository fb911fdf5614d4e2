#include "analysis/statistics/figures/streams.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {
namespace {

CompensatedSequence empty_sequence(const SequenceData& data, int taxels) {
  CompensatedSequence sequence;
  sequence.raw = average_repeats(data, taxels);
  const std::size_t steps = sequence.raw.pressure_psi.size();
  sequence.pressure = {sequence.raw.pressure_psi, std::vector<double>(sequence.raw.values.size(), 0.0),
                       sequence.raw.branches};
  sequence.flat = sequence.pressure;
  sequence.unmoved_psi.assign(sequence.raw.values.size(), 0.0);
  sequence.reference_psi.assign(steps, 0.0);
  for (const Repeat& repeat : data.repeats)
    for (std::size_t i = 0; i < steps; ++i)
      sequence.reference_psi[i] += repeat.steps[i].reference_psi / static_cast<double>(data.repeats.size());
  return sequence;
}

void add_error(TaxelErrors& errors, double error, double reference_psi, bool flat) {
  ++errors.frames;
  errors.sum_psi += error;
  if (error > errors.max_psi) {
    errors.max_psi = error;
    errors.max_at_psi = reference_psi;
  }
  if (flat) return;
  ++errors.observable;
  errors.sum_observable_psi += error;
  errors.max_observable_psi = std::max(errors.max_observable_psi, error);
}

}  // namespace

CompensatedStreams compensate_all(const Dataset& dataset, const SensorModel& fit, int threads) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  CompensatedStreams streams;
  streams.errors.resize(width);
  for (const SequenceData& data : dataset.sequences)
    streams.sequences.push_back(empty_sequence(data, dataset.taxels()));

  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
      CompensatedSequence& sequence = streams.sequences[s];
      const double weight = 1.0 / static_cast<double>(repeats.size());
      const Sample& sample = repeats[r].steps[i];
      const std::size_t at = i * width + taxel;
      sequence.unmoved_psi[at] += weight * now.pressure_psi;
      sequence.pressure.values[at] += weight * (now.pressure_psi + sample.setpoint_psi - sample.reference_psi);
      sequence.flat.values[at] += now.flat ? weight : 0.0;
      add_error(streams.errors[taxel], std::abs(now.pressure_psi - sample.reference_psi), sample.reference_psi,
                now.flat);
    };
  });
  return streams;
}

}  // namespace tactbench::analysis
