#include "analysis/compensate/model_compensator.h"

#include <algorithm>
#include <cmath>

#include "analysis/models/elam_hysteresis.h"

namespace tactbench::analysis {

ModelCompensator::ModelCompensator(const HysteresisModel& model, const TaxelOutputs& outputs,
                                   const CompensatorOptions& options)
    : model_(&model), outputs_(outputs), options_(options) {
  const auto* const elam = dynamic_cast<const ElamHysteresis*>(&model);
  if (elam != nullptr && elam->is_paper()) {
    elam_.emplace(elam->elam(), options);
  } else {
    check_options(options);
    stream_.emplace(model, outputs.dead_band);
  }
}

void ModelCompensator::reset() {
  if (elam_)
    elam_->reset();
  else
    stream_.emplace(*model_, outputs_.dead_band);
}

Compensated ModelCompensator::step(double output) {
  if (elam_) return elam_->step(output);
  Compensated result;
  result.pressure_psi = stream_->step(output);
  const double off = options_.flat_in_noises * options_.noise_v;
  if (off > 0.0) {
    const double moved = std::max(std::abs(result.pressure_psi - stream_->reads(output - off)),
                                  std::abs(stream_->reads(output + off) - result.pressure_psi));
    result.uncertainty_psi = moved / options_.flat_in_noises;
    result.flat = moved > options_.flat_psi;
  }
  result.out_of_range = output < outputs_.low - outputs_.dead_band || output > outputs_.high + outputs_.dead_band;
  return result;
}

}  // namespace tactbench::analysis
