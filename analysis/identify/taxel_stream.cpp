#include "analysis/identify/taxel_stream.h"

#include <fmt/format.h>

#include <span>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/dynamic_setup_of.h"

namespace tactbench::analysis {
namespace {

// Of a sample, in the model's own outputs.
double noise_of(const ModelTaxel& taxel, double noisier) { return noisier * taxel.noise / taxel.gain; }

CompensatorOptions options_of(const ModelTaxel& taxel, double noisier) {
  CompensatorOptions options;
  options.noise_v = noise_of(taxel, noisier);
  return options;
}

TaxelOutputs outputs_of(const ModelTaxel& taxel, double noisier) {
  return {taxel.loop_low, taxel.loop_low + taxel.fit.full_scale, kBandInNoises * noise_of(taxel, noisier)};
}

}  // namespace

TaxelStream::TaxelStream(const ModelTaxel& taxel, double noisier)
    : taxel_(&taxel), compensator_(*taxel.fit.model, outputs_of(taxel, noisier), options_of(taxel, noisier)) {}

TaxelStream::TaxelStream(const SensorModel& model, const ModelTaxel& taxel, double noisier)
    : TaxelStream(taxel, noisier) {
  if (!model.dynamics || !taxel.fitted()) return;
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
}

Compensated TaxelStream::step(double output, double seconds) {
  return dynamic_ ? dynamic_->step(output, seconds) : compensator_.step(taxel_->to_model(output));
}

void TaxelStream::work(double seconds) {
  if (dynamic_) dynamic_->work(seconds);
}

void TaxelStream::reset() {
  compensator_.reset();
  if (dynamic_) dynamic_->reset();
}

void TaxelStream::rest(double seconds) {
  compensator_.reset();
  if (dynamic_) dynamic_->rest(seconds);
}

}  // namespace tactbench::analysis
