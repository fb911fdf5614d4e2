// A taxel of a sensor's model as a stream: outputs as measured in, inputs out.
#pragma once

#include "analysis/compensate/model_compensator.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

class TaxelStream {
 public:
  // Of a taxel that has a model, at rest; its dead band is that of the noise found with the fit. Keeps a pointer to
  // `taxel`. `noisier`: by how much more noise a sample has than those that were fitted.
  explicit TaxelStream(const ModelTaxel& taxel, double noisier = 1.0);
  // The output as measured, of a falling sensor negated. Throws std::invalid_argument when it is not finite.
  Compensated step(double output) { return compensator_.step(taxel_->to_model(output)); }
  void reset() { compensator_.reset(); }

 private:
  const ModelTaxel* taxel_;
  ModelCompensator compensator_;
};

}  // namespace tactbench::analysis
