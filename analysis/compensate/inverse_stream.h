// Outputs in, inputs out, sample by sample, by any hysteresis model: models are compared by this one rule of
// compensation. (The compensator for ELAM does more: frame_compensator.h.)
#pragma once

#include <memory>
#include <optional>

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
  // What a next sample of `output` would give; nothing is remembered of it.
  [[nodiscard]] double reads(double output) const;
  void reset();  // to the virgin state
  // The next output is on a branch that began before. Of all histories one that only rose ends at the highest input and
  // one that fell from the top at the lowest: both are followed, the estimate lies midway, until both are within 1 % of
  // the input's range of each other (as TaxelCompensator).
  void reset_unknown();

 private:
  struct Way {
    std::unique_ptr<ModelState> state;
    double furthest = 0.0;
    int direction = 1;  // that of rest at the lowest input
    bool begun = false;
    double step(double output, double dead_band);
  };
  const HysteresisModel* model_;
  double dead_band_;
  Way way_;
  std::optional<Way> other_;  // unknown: the one that fell from the top
};

}  // namespace tactbench::analysis
