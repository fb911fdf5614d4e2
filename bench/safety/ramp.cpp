#include "bench/safety/ramp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/common/process_time.h"

namespace tactbench::bench {

namespace {

constexpr double kRampTick = 0.1;  // s of process time between two set-points

}  // namespace

double ramp_tick_psi(const SafetyLimits& limits, double rate_psi_per_s) {
  return std::min(rate_psi_per_s * kRampTick, limits.step_psi);
}

std::uint16_t ramp_to(Rig& rig, devices::Psi level, devices::Psi& setpoint, double tick_psi, const RampHooks& hooks) {
  for (bool first = true;; first = false) {
    const double left = (level - setpoint).value();
    const bool last = std::abs(left) <= tick_psi * (1.0 + 1e-9) || std::isnan(left);
    const RampTick tick{first, last, kRampTick * (last ? std::abs(left) / tick_psi : 1.0)};
    if (hooks.before) hooks.before(tick);
    setpoint = last ? level : setpoint + devices::Psi(std::copysign(tick_psi, left));
    const std::uint16_t counts = rig.source().command(setpoint);
    if (hooks.after) hooks.after(tick);
    if (last) return counts;
  }
}

std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick) {
  const SafetyLimits& limits = rig.config().limits;
  devices::Psi setpoint(rig.guard().setpoint_psi());
  const double tick_psi =
      level < setpoint ? std::numeric_limits<double>::infinity() : ramp_tick_psi(limits, limits.rate_psi_per_s);
  RampHooks hooks;
  hooks.before = [&](const RampTick&) {
    (void)rig.source().feedback();
    (void)rig.reference().read();
  };
  hooks.after = [&](const RampTick& tick) {
    if (tick.last) return;
    rig.clock().wait_until(rig.clock().now() + seconds(tick.seconds));
    if (each_tick) each_tick();
  };
  return ramp_to(rig, level, setpoint, tick_psi, hooks);
}

}  // namespace tactbench::bench
