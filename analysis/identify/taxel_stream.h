// A taxel of a sensor's model as a stream: outputs as measured in, inputs out.
#pragma once

#include <memory>
#include <optional>

#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/model_compensator.h"
#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

class TaxelStream {
 public:
  // Of a taxel that has a model, at rest; its dead band is that of the noise found with the fit. Keeps a pointer to
  // `taxel`. `noisier`: by how much more noise a sample has than those that were fitted.
  explicit TaxelStream(const ModelTaxel& taxel, double noisier = 1.0);
  // The same, with lag and creep undone where the model has them and the taxel is fitted. Throws AnalysisError
  // TB-MODEL-COMPENSATOR when the model's numbers make no dynamic compensator.
  TaxelStream(const SensorModel& model, const ModelTaxel& taxel, double noisier = 1.0);
  // The sensor was conditioned for so long since the sample before. Only models with lag and creep look at it.
  void work(double seconds);
  // The output as measured, of a falling sensor negated. `seconds` since the sample before, which only models with lag
  // and creep look at; 0: not known. Throws std::invalid_argument when a value is not finite, or seconds is negative.
  Compensated step(double output, double seconds = 0.0);
  void reset();
  // The load was taken off, and the film rested for so long: the history is forgotten, creep and lag went on.
  void rest(double seconds);

 private:
  const ModelTaxel* taxel_;
  ModelCompensator compensator_;
  std::unique_ptr<const DynamicSetup> setup_;  // of dynamic_
  std::optional<DynamicTaxelCompensator> dynamic_;
};

// The stored samples of a dataset through `stream` (a TaxelStream, or what has its step and work), in time order: state
// carries over from repeat to repeat and from sequence to sequence. `volts(repeat, i)`: the output at step i of the
// repeat. Calls take(s, r, i, Compensated) for step i of repeat r of sequence s.
template <class Stream, class Volts, class Take>
void stream_samples(const Dataset& dataset, Stream& stream, const Volts& volts, Take take) {
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
