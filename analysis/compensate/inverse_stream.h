// Outputs in, inputs out, sample by sample, by any hysteresis model: models are compared by this one rule of
// compensation. (The compensator for ELAM does more: frame_compensator.h.)
#pragma once

#include <memory>

#include "analysis/models/model.h"

namespace tactbench::analysis {

// Direction comes from the output. Behind the furthest output since the last turn the estimate reads the way back from
// there, but only an output that went back by more than the dead band is remembered as a turn [A13].
class InverseStream {
 public:
  // Starts from a virgin state. Keeps a pointer to `model`. Throws std::invalid_argument when `dead_band` is negative
  // or not finite.
  InverseStream(const HysteresisModel& model, double dead_band);
  // Throws std::invalid_argument when `output` is not finite; the state is then as before.
  double step(double output);

 private:
  std::unique_ptr<ModelState> state_;
  double dead_band_;
  double furthest_ = 0.0;
  int direction_ = 0;  // 0: no sample yet
};

}  // namespace tactbench::analysis
