// A recording of a taxel as a stream: outputs as measured in, inputs out, from a start at rest or in mid-branch, with
// the model's residual in the uncertainty.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/model_compensator.h"
#include "analysis/compensate/residual_bins.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

class RecordingStream {
 public:
  // Of a taxel that has a model, at rest. Keeps a pointer to `taxel`. `noisier`: by how much more noise a sample has
  // than those that were fitted. Throws AnalysisError TB-MODEL-COMPENSATOR as TaxelStream.
  RecordingStream(const SensorModel& model, const ModelTaxel& taxel, double noisier = 1.0);
  // A first output that is the unloaded one, within the dead band and 1 % of the span: a start at rest. Any other is on
  // a branch that began before.
  [[nodiscard]] bool at_rest(double output) const;
  void reset();
  // The next output is on a branch that began before: the highest and the lowest history that end in it are followed,
  // the estimate lies midway, until they meet.
  void reset_unknown();
  void work(double seconds);  // as TaxelStream's
  // As TaxelStream's. The uncertainty contains noise, the unknown part of the history, and what the model leaves.
  Compensated step(double output, double seconds = 0.0);
  [[nodiscard]] bool ascending() const;

 private:
  // Of models that are neither ELAM's nor dynamic: one history that only rose, another that fell from the top.
  struct Inverse {
    ModelCompensator low;
    std::optional<InverseStream> midway;  // while the history is not known
    double furthest = 0.0;
    bool begun = false, ascending = true;
  };
  Compensated by_inverse(double output);

  const ModelTaxel* taxel_;
  double dead_band_ = 0.0;  // in the model's own outputs
  std::vector<double> residual_;
  std::optional<TaxelCompensator> elam_;
  std::unique_ptr<const DynamicSetup> setup_;  // of dynamic_
  std::optional<DynamicTaxelCompensator> dynamic_;
  std::optional<Inverse> inverse_;
};

}  // namespace tactbench::analysis
