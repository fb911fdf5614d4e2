#include "bench/safety/ramp.h"

#include <algorithm>

#include "bench/process_time.h"

namespace tactbench::bench {

std::uint16_t ramp_to(Rig& rig, devices::Psi level, const std::function<void()>& each_tick) {
  constexpr double kTick = 0.1;
  const SafetyLimits& limits = rig.config().limits;
  const double rise = std::min(limits.rate_psi_per_s * kTick, limits.step_psi);
  for (;;) {
    const double next = std::min(level.value(), rig.guard().setpoint_psi() + rise);
    (void)rig.source().feedback();
    (void)rig.reference().read();
    const std::uint16_t counts = rig.source().command(devices::Psi(next));
    if (!(next < level.value())) return counts;  // not-a-number has been refused
    rig.clock().wait_until(rig.clock().now() + seconds(kTick));
    if (each_tick) each_tick();
  }
}

}  // namespace tactbench::bench
