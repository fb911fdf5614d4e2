#include "analysis/compensate/inverse_stream.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

namespace {
constexpr double kSameInput = 0.01;  // of the range: both ways have come to one
}

InverseStream::InverseStream(const HysteresisModel& model, double dead_band) : model_(&model), dead_band_(dead_band) {
  if (!std::isfinite(dead_band) || dead_band < 0.0)
    throw std::invalid_argument("the dead band is negative or not a finite number");
  reset();
}

void InverseStream::reset() {
  way_ = {model_->state()};
  other_.reset();
}

void InverseStream::reset_unknown() {
  reset();
  other_ = Way{model_->state(), 0.0, -1, false};
  other_->state->go(model_->x_high());
}

double InverseStream::step(double output) {
  if (!std::isfinite(output)) throw std::invalid_argument("the output is not a finite number");
  const double input = way_.step(output, dead_band_);
  if (!other_) return input;
  const double other = other_->step(output, dead_band_);
  if (std::abs(other - input) <= kSameInput * (model_->x_high() - model_->x_low())) other_.reset();
  return 0.5 * (input + other);
}

double InverseStream::reads(double output) const {
  const double input = way_.state->input_at(output);
  return other_ ? 0.5 * (input + other_->state->input_at(output)) : input;
}

double InverseStream::Way::step(double output, double dead_band) {
  if (!begun) furthest = output;
  begun = true;
  const double input = state->input_at(output);
  const double ahead = (output - furthest) * direction;
  if (ahead < -dead_band) direction = -direction;
  if (ahead >= 0.0 || ahead < -dead_band) {
    furthest = output;
    state->go(input);
  }
  return input;
}

}  // namespace tactbench::analysis
