#include "analysis/identify/taxel_stream.h"

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

}  // namespace tactbench::analysis
