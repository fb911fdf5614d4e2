#include "analysis/identify/streams/recording_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/dynamic_setup_of.h"
#include "analysis/identify/residuals.h"

namespace tactbench::analysis {
namespace {

constexpr double kAtRestShare = 0.01;    // of the output's span
constexpr double kSettledInput = 1e-12;  // of the input's range: InverseStream has settled

}  // namespace

RecordingStream::RecordingStream(const SensorModel& model, const ModelTaxel& taxel, double noisier)
    : taxel_(&taxel), dead_band_(kBandInNoises * noisier * taxel.noise / taxel.gain) {
  if (model.dynamics && taxel.fitted()) {
    DynamicSetup setup = dynamic_setup_of(model, std::span(&taxel, 1), 1.0, noisier);
    setup.taxels.front().falling = false;  // step() is given outputs that rise
    setup_ = std::make_unique<const DynamicSetup>(std::move(setup));
    try {
      dynamic_.emplace(*setup_, 0);
    } catch (const std::invalid_argument& error) {
      throw AnalysisError("TB-MODEL-COMPENSATOR",
                          fmt::format("{}, taxel {}: {}", model.source, taxel.taxel, error.what()),
                          "check its parameters (tactbench model show), or fit it again");
    }
    return;
  }
  residual_ = residual_by_level(taxel);
  CompensatorOptions options;
  options.noise_v = noisier * taxel.noise / taxel.gain;
  if (const ElamModel* const elam = paper_elam_of(taxel)) {
    elam_.emplace(*elam, options);
    return;
  }
  const TaxelOutputs outputs{taxel.loop_low, taxel.loop_low + taxel.fit.full_scale, dead_band_};
  inverse_.emplace(Inverse{ModelCompensator(*taxel.fit.model, outputs, options), std::nullopt});
}

bool RecordingStream::at_rest(double output) const {
  return taxel_->to_model(output) <= taxel_->loop_low + std::max(kAtRestShare * taxel_->fit.full_scale, dead_band_);
}

void RecordingStream::reset() {
  if (elam_) elam_->reset();
  if (dynamic_) dynamic_->reset();
  if (!inverse_) return;
  inverse_->low.reset();
  inverse_->midway.reset();
  inverse_->begun = false;
  inverse_->ascending = true;
}

void RecordingStream::reset_unknown() {
  reset();
  if (elam_) elam_->reset_unknown();
  if (dynamic_) dynamic_->reset_unknown();
  if (inverse_) inverse_->midway.emplace(*taxel_->fit.model, dead_band_).reset_unknown();
}

void RecordingStream::work(double seconds) {
  if (dynamic_) dynamic_->work(seconds);
}

bool RecordingStream::ascending() const {
  if (elam_) return elam_->ascending();
  return dynamic_ ? dynamic_->ascending() : inverse_->ascending;
}

Compensated RecordingStream::by_inverse(double output) {
  Inverse& own = *inverse_;
  Compensated result = own.low.step(output);
  // The rule of InverseStream.
  if (!own.begun) own.furthest = output;
  own.begun = true;
  const double ahead = own.ascending ? output - own.furthest : own.furthest - output;
  if (ahead < -dead_band_) own.ascending = !own.ascending;
  if (ahead >= 0.0 || ahead < -dead_band_) own.furthest = output;
  if (!own.midway) return result;
  const double midway = own.midway->step(output), half = std::abs(midway - result.pressure_psi);
  if (half <= kSettledInput * (taxel_->fit.model->x_high() - taxel_->fit.model->x_low())) {
    own.midway.reset();
    return result;
  }
  result.pressure_psi = midway;
  result.uncertainty_psi = std::hypot(result.uncertainty_psi, half);
  result.unknown = true;
  return result;
}

Compensated RecordingStream::step(double output, double seconds) {
  if (dynamic_) return dynamic_->step(output, seconds);
  Compensated result = elam_ ? elam_->step(taxel_->to_model(output)) : by_inverse(taxel_->to_model(output));
  if (residual_.empty()) return result;
  const ResidualBins bins{taxel_->x0(), taxel_->xu(), residual_};
  result.uncertainty_psi = std::hypot(result.uncertainty_psi, bins.at(result.pressure_psi, ascending()));
  return result;
}

}  // namespace tactbench::analysis
