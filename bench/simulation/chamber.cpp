#include "bench/simulation/chamber.h"

#include <algorithm>
#include <cmath>

namespace tactbench::bench {
namespace {

constexpr double kStepSeconds = 0.0025;  // a 48th of the default time constant
constexpr double kModuleVolts = 10.0;
constexpr double kOvershootSeconds = 2.0;
constexpr double kOvershootShare = 0.9;  // turned back here; what the chamber has of speed brings the rest
constexpr double kLeadPerPsi = 0.25;     // how fast the hysteresis turns over: fully within 4 widths of travel

}  // namespace

void Chamber::command(devices::Volts volts) {
  double seen = std::clamp(volts.value(), 0.0, kModuleVolts);
  if (options_.resolution_v > 0.0) seen = std::round(seen / options_.resolution_v) * options_.resolution_v;
  target_psi_ = options_.low_psi + seen / kModuleVolts * (options_.span_psi - options_.low_psi);
}

void Chamber::overshoot(double psi) {
  beyond_psi_ = psi;
  beyond_s_ = kOvershootSeconds;
}

void Chamber::advance(double seconds) {
  const auto whole = static_cast<long>(seconds / kStepSeconds + 1e-9);
  for (long i = 0; i < whole; ++i) step(kStepSeconds);
  const double rest = seconds - static_cast<double>(whole) * kStepSeconds;
  if (rest > 1e-12) step(rest);
}

void Chamber::step(double seconds) {
  // p'' = w^2 (target - p) - 2 z w p', rate limited; semi-implicit Euler.
  const double omega = 1.0 / options_.time_constant_s;
  const double pull = omega * omega * (target_psi_ + beyond_psi_ - believed_psi_);
  const double drag = 2.0 * options_.damping * omega * rate_psi_per_s_;
  rate_psi_per_s_ =
      std::clamp(rate_psi_per_s_ + (pull - drag) * seconds, -options_.slew_psi_per_s, options_.slew_psi_per_s);
  if (trouble_.no_supply_fall_psi_per_s > 0.0) {
    rate_psi_per_s_ = std::min(rate_psi_per_s_, -trouble_.no_supply_fall_psi_per_s);
  }
  if (trouble_.valve_shut) rate_psi_per_s_ = 0.0;
  const double lost = trouble_.leak_psi_per_s + (dump_open_ ? options_.dump_psi_per_s : 0.0);
  const double before = believed_psi_;
  believed_psi_ += (rate_psi_per_s_ - options_.leak_psi_per_s - lost) * seconds;
  if (beyond_psi_ != 0.0) {
    beyond_s_ -= seconds;
    const double gone = (believed_psi_ - target_psi_) / beyond_psi_;
    if (gone >= kOvershootShare || beyond_s_ <= 0.0) beyond_psi_ = 0.0;
  }
  const double lowest = std::min(0.0, options_.low_psi);  // only a regulator for vacuum makes one
  if (believed_psi_ < lowest) {
    believed_psi_ = lowest;
    rate_psi_per_s_ = std::max(0.0, rate_psi_per_s_);
  }
  const double half = 0.5 * options_.hysteresis_share * options_.span_psi;
  lead_psi_ = std::clamp(lead_psi_ + kLeadPerPsi * (believed_psi_ - before), -half, half);
  pressure_psi_ = std::max(lowest, believed_psi_ + lead_psi_);
}

}  // namespace tactbench::bench
