// Compensation of one taxel by any model: ELAM as in the paper by the product's own compensator, every other model by
// the rule that all models are compared with (inverse_stream.h).
#pragma once

#include <memory>
#include <optional>

#include "analysis/compensate/compensator.h"
#include "analysis/compensate/inverse_stream.h"
#include "analysis/compensate/options.h"
#include "analysis/models/model.h"

namespace tactbench::analysis {

// The model's range of its taxel, in the model's own outputs.
struct TaxelOutputs {
  double low = 0.0, high = 0.0;  // ends of the external loop
  double dead_band = 0.0;        // of models that are not ELAM's
};

class ModelCompensator {
 public:
  // Starts at rest at the lowest input. Keeps a pointer to `model`. Throws std::invalid_argument on negative options.
  ModelCompensator(const HysteresisModel& model, const TaxelOutputs& outputs, const CompensatorOptions& options);
  // Throws std::invalid_argument when `output` is not finite; the state is then as before. The uncertainty of models
  // that are not ELAM's is that of a sample's noise, by the inverse's difference for an output flat_in_noises off.
  Compensated step(double output);
  void reset();

 private:
  const HysteresisModel* model_;
  TaxelOutputs outputs_;
  CompensatorOptions options_;
  std::optional<TaxelCompensator> elam_;
  std::optional<InverseStream> stream_;
};

}  // namespace tactbench::analysis
