#include "analysis/compensate/inverse_stream.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

InverseStream::InverseStream(const HysteresisModel& model, double dead_band)
    : state_(model.state()), dead_band_(dead_band) {
  if (!std::isfinite(dead_band) || dead_band < 0.0)
    throw std::invalid_argument("the dead band is negative or not a finite number");
}

double InverseStream::step(double output) {
  if (!std::isfinite(output)) throw std::invalid_argument("the output is not a finite number");
  if (direction_ == 0) {
    direction_ = 1;  // from rest at the lowest input
    furthest_ = output;
  }
  const double input = state_->input_at(output);
  const double ahead = (output - furthest_) * direction_;
  if (ahead < -dead_band_) direction_ = -direction_;
  if (ahead >= 0.0 || ahead < -dead_band_) {
    furthest_ = output;
    state_->go(input);
  }
  return input;
}

}  // namespace tactbench::analysis
