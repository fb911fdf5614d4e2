#include "analysis/compensate/frame_compensator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace tactbench::analysis {

double FrameCompensator::checked(std::size_t outputs, double seconds, const Output& output) {
  const std::size_t count = taxels();
  if (outputs != count || output.pressure_psi.size() != count || output.uncertainty_psi.size() != count ||
      output.status.size() != count)
    throw std::invalid_argument(
        "frames: the number of samples, or of values in an output, differs from the number of taxels");
  if (!begun_) return 0.0;
  if (std::isnan(seconds) && !setup_.in_time) return 0.0;
  if (std::isnan(seconds))
    throw std::invalid_argument(
        "frames: the model compensates lag and creep, but the time since the previous frame is not given");
  if (seconds < 0.0 || std::isinf(seconds))
    throw std::invalid_argument("frames: the time since the previous frame is negative or infinite");
  return seconds;
}

void FrameCompensator::put(std::size_t taxel, const Compensated& now, int bits, const Output& output) const {
  if (now.out_of_range)
    bits |= kTaxelOutOfRange;
  else if (!now.held && !outside_)
    bits |= kTaxelValid;
  if (now.flat) bits |= kTaxelFlat;
  if (now.unknown) bits |= kTaxelUnknown;
  if (outside_ && bits != kTaxelDead) bits |= kTaxelOutside;
  output.pressure_psi[taxel] = static_cast<float>(now.pressure_psi);
  output.uncertainty_psi[taxel] = static_cast<float>(std::min(now.uncertainty_psi, setup_.x_high - setup_.x_low));
  output.status[taxel] = static_cast<std::uint16_t>(bits);
}

void FrameCompensator::frame(std::span<const float> outputs, double seconds, const Output& output) {
  const double passed = checked(outputs.size(), seconds, output);
  const Compensated dead{setup_.x_low, setup_.x_high - setup_.x_low, false, false, false, true};
  for (std::size_t t = 0; t < outputs.size(); ++t) {
    if (setup_.taxels[t] == nullptr)
      put(t, dead, kTaxelDead, output);
    else
      put(t, setup_.taxels[t]->step(static_cast<double>(outputs[t]), passed),
          std::isfinite(outputs[t]) ? 0 : kTaxelLost, output);
  }
  begun_ = true;
  gap_ = 0;
}

void FrameCompensator::lost_frame(double seconds, const Output& output) {
  const double passed = checked(taxels(), seconds, output);
  const bool unknown = ++gap_ > setup_.max_gap;
  const Compensated dead{setup_.x_low, setup_.x_high - setup_.x_low, false, false, false, true};
  for (std::size_t t = 0; t < taxels(); ++t) {
    Compensator* const own = setup_.taxels[t].get();
    if (own == nullptr) {
      put(t, dead, kTaxelDead, output);
      continue;
    }
    if (unknown) own->start(Start::kUnknown);
    put(t, own->lost(passed), kTaxelLost, output);
  }
}

void FrameCompensator::start(Start how) {
  begun_ = false;
  gap_ = 0;
  for (const auto& own : setup_.taxels)
    if (own != nullptr) own->start(how);
}

void FrameCompensator::work(double seconds) {
  for (const auto& own : setup_.taxels)
    if (own != nullptr) own->work(seconds);
}

std::size_t FrameCompensator::tare(std::span<const float> outputs) {
  if (outputs.size() != taxels())
    throw std::invalid_argument("frames: the number of samples differs from the number of taxels");
  std::size_t refused = 0;
  begun_ = false;
  gap_ = 0;
  for (std::size_t t = 0; t < outputs.size(); ++t)
    if (setup_.taxels[t] != nullptr && !setup_.taxels[t]->tare(static_cast<double>(outputs[t]))) ++refused;
  return refused;
}

}  // namespace tactbench::analysis
