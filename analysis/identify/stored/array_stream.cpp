#include "analysis/identify/stored/array_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/error.h"
#include "analysis/identify/dynamic_setup_of.h"
#include "analysis/identify/stored/model_document.h"

namespace tactbench::analysis {
namespace {

bool is_paper(const SensorModel& model) {
  return std::ranges::all_of(
      model.array(), [](const ModelTaxel& taxel) { return !taxel.fitted() || paper_elam_of(taxel) != nullptr; });
}

}  // namespace

ArrayStream::ArrayStream(const SensorModel& model, double volts_per_count, double noisier, int longest_gap)
    : model_(&model) {
  if (is_paper(model)) {
    FrameSetup setup = frame_setup_of(model, volts_per_count);
    setup.longest_gap = longest_gap;
    for (TaxelSetup& taxel : setup.taxels) taxel.noise_v *= noisier;
    elam_.emplace(setup);
    return;
  }
  if (model.array().size() != static_cast<std::size_t>(model.rows) * static_cast<std::size_t>(model.columns))
    throw AnalysisError(
        "TB-MODEL-COMPENSATOR",
        fmt::format("{} of {} cannot compensate frames: it is not of a whole array", label_of(model), model.source),
        "fit a run of the array: tactbench fit RUN");
  if (model.dynamics) {
    DynamicSetup setup = dynamic_setup_of(model, model.array(), volts_per_count, noisier);
    setup.longest_gap = longest_gap;
    dynamic_.emplace(setup);
    return;
  }
  longest_gap_ = longest_gap;
  for (const ModelTaxel& taxel : model.array()) {
    streams_.emplace_back();
    if (taxel.fitted()) streams_.back().emplace(model, taxel, noisier).reset_unknown();
  }
  last_psi_.assign(taxels(), static_cast<float>(model.pressure_psi.front()));
  last_uncertainty_psi_.assign(taxels(), static_cast<float>(model.pressure_psi.back() - model.pressure_psi.front()));
}

std::uint16_t ArrayStream::step(std::size_t taxel, float volts, float& pressure, float& uncertainty) {
  if (!streams_[taxel]) return kTaxelDead;
  if (!std::isfinite(volts)) return kTaxelLost;
  const double output = static_cast<double>(volts);
  const Compensated now = streams_[taxel]->step(model_->falling ? -output : output);
  pressure = static_cast<float>(now.pressure_psi);
  uncertainty = static_cast<float>(now.uncertainty_psi);
  int bits = now.out_of_range ? kTaxelOutOfRange : kTaxelValid;
  if (now.flat) bits |= kTaxelFlat;
  if (now.unknown) bits |= kTaxelUnknown;
  return static_cast<std::uint16_t>(bits);
}

void ArrayStream::frame(std::span<const float> volts, const Output& output) {
  if (elam_) return elam_->frame(volts, output);
  if (dynamic_) return dynamic_->frame(volts, output);
  gap_ = 0;
  frame_of_streams(volts, output);
}

void ArrayStream::frame_of_streams(std::span<const float> volts, const Output& output) {
  for (std::size_t i = 0; i < taxels(); ++i) {
    output.status[i] = step(i, volts[i], last_psi_[i], last_uncertainty_psi_[i]);
    if (outside_ && output.status[i] != kTaxelDead)
      output.status[i] = static_cast<std::uint16_t>((output.status[i] & ~kTaxelValid) | kTaxelOutside);
    output.pressure_psi[i] = last_psi_[i];
    output.uncertainty_psi[i] = last_uncertainty_psi_[i];
  }
}

void ArrayStream::lost_frame(const Output& output) {
  if (elam_) return elam_->lost_frame(output);
  if (dynamic_) return dynamic_->lost_frame(output);
  if (++gap_ > longest_gap_)
    for (std::optional<RecordingStream>& stream : streams_)
      if (stream) stream->reset_unknown();
  const std::vector<float> none(taxels(), std::nanf(""));
  frame_of_streams(none, output);
}

void ArrayStream::set_outside_validity(bool outside) {
  outside_ = outside;
  if (elam_) elam_->set_outside_validity(outside);
  if (dynamic_) dynamic_->set_outside_validity(outside);
}

void ArrayStream::set_interval(double seconds) {
  if (dynamic_) dynamic_->set_interval(seconds);
}

}  // namespace tactbench::analysis
