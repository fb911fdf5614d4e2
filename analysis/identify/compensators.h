// Makes streaming compensators from a sensor's model: for one taxel, for the stored samples of a dataset, for frames of
// the array.
#pragma once

#include <memory>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Of a taxel that has a model, at rest, with lag and creep removed where the model has them and the taxel is fitted.
// Outputs as measured, of a falling sensor negated. Keeps a pointer to `taxel`. `noisier`: by how much more noise a
// sample has than those that were fitted. Throws AnalysisError TB-MODEL-COMPENSATOR when the model's numbers make none.
std::unique_ptr<Compensator> compensator_of(const SensorModel& model, const ModelTaxel& taxel, double noisier = 1.0);

// Of the array, from any state; outputs as measured. Keeps a pointer to `model`. Throws as compensator_of, also when
// the model is not of a whole array.
FrameCompensator frames_of(const SensorModel& model, double noisier = 1.0, int max_gap = 10);

// The stored samples of a dataset through `stream`, in time order: state carries over from repeat to repeat and from
// sequence to sequence. `volts(repeat, i)`: the output at step i of the repeat. Calls take(s, r, i, Compensated) for
// step i of repeat r of sequence s.
template <class Volts, class Take>
void stream_samples(const Dataset& dataset, Compensator& stream, const Volts& volts, Take take) {
  double before_s = -1.0;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r)
      for (std::size_t i = 0; i < repeats[r].steps.size(); ++i) {
        const TimePassed passed = time_passed(repeats[r].steps[i], before_s);
        before_s = repeats[r].steps[i].time_s;
        if (passed.worked_s > 0.0) stream.work(passed.worked_s);
        take(s, r, i, stream.step(volts(repeats[r], i), passed.step_s));
      }
  }
}

}  // namespace tactbench::analysis
