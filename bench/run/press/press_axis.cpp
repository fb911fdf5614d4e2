#include "bench/run/press/press_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/common/process_time.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Axis;
using devices::Fault;
using devices::Millimetres;
using devices::MillimetresPerSecond;
using devices::Nanoseconds;

double PressOptions::tolerance(double force_n) const {
  return std::max(tolerance_n, tolerance_share * std::abs(force_n));
}

double PressOptions::travel_limit_mm_per_s() const {
  const double unseen_s = poll_interval_s + force_latency_s + stop_time_s;
  return std::min(travel_mm_per_s, (force_limit_n - contact_n) / (stiffest_n_per_mm * unseen_s));
}

// Stops the axis first: handling the fault takes time.
template <class Act>
auto PressAxis::guarded(Act act) {
  try {
    return act();
  } catch (...) {
    (void)stage_.halt();
    throw;
  }
}

double PressAxis::find() {
  const devices::AxisState state = stage_.state(Axis::kZ);
  if (!state.homed) {
    throw Fault("TB-PRESS-NOT-HOMED", "stage z",
                "a move of z under force was requested before it was homed; nothing was sent");
  }
  return z_mm_ = state.position.value();
}

ForceSample PressAxis::read(int records, bool moving) {
  const devices::ForceReading reading = force_.read(records);
  const ForceSample taken{
      reading.time, z_mm_,           moving, reading.wrench, options_.pressing_sign * reading.wrench.force_n[2],
      reading.raw,  reading.spread_n};
  last_n_ = taken.force_n;
  if (hooks_.sample) hooks_.sample(taken);
  if (!(std::abs(taken.force_n) <= options_.force_limit_n)) {  // NaN is beyond
    throw Fault("TB-PRESS-FORCE-LIMIT", "force sensor",
                fmt::format("{:.2f} N on the indenter, the limit is {:g} N; {}", taken.force_n, options_.force_limit_n,
                            stopped()));
  }
  return taken;
}

std::string PressAxis::stopped() {
  try {
    z_mm_ = stage_.stop(Axis::kZ).value();
    return fmt::format("z was stopped at {:.3f} mm", z_mm_);
  } catch (const Fault& fault) {
    return fmt::format("the position of z is not known ({})", fault.what());
  }
}

ForceSample PressAxis::sample(int records) {
  return guarded([&] { return read(records, false); });
}

bool PressAxis::felt() { return std::abs(read(options_.poll_records, true).force_n) >= options_.contact_n; }

ForceSample PressAxis::move_to(double z_mm, double speed_mm_per_s) {
  return guarded([&] {
    const bool toward = z_mm > z_mm_;
    stage_.start_move_to(Axis::kZ, Millimetres(z_mm), MillimetresPerSecond(speed_mm_per_s));
    const Nanoseconds end = clock_.now() + seconds(std::abs(z_mm - z_mm_) / speed_mm_per_s + options_.settle_s);
    while (toward) {
      // Distance to the limit at the greatest stiffness, minus the travel before the stage reacts.
      const double way_s = (options_.force_limit_n - last_n_) / (options_.stiffest_n_per_mm * speed_mm_per_s);
      const double reaction_s = options_.force_latency_s + options_.stop_time_s;
      const Nanoseconds next = clock_.now() + seconds(std::max(options_.poll_interval_s, way_s - reaction_s));
      if (next >= end) break;
      hooks_.wait(next);
      (void)read(options_.poll_records, true);
    }
    hooks_.wait(end);
    z_mm_ = stage_.wait(Axis::kZ).value();
    return read(options_.level_records, false);
  });
}

bool PressAxis::descend(double z_mm, double speed_mm_per_s) {
  return guarded([&] {
    stage_.start_move_to(Axis::kZ, Millimetres(z_mm), MillimetresPerSecond(speed_mm_per_s));
    const Nanoseconds end = clock_.now() + seconds(std::abs(z_mm - z_mm_) / speed_mm_per_s + options_.settle_s);
    while (clock_.now() < end) {
      hooks_.wait(std::min(end, clock_.now() + seconds(options_.poll_interval_s)));
      if (!felt() || !felt()) continue;  // one reading alone may be a shock
      z_mm_ = stage_.stop(Axis::kZ).value();
      return true;
    }
    z_mm_ = stage_.wait(Axis::kZ).value();
    return false;
  });
}

void PressAxis::event(const std::string& id, const std::string& text) const {
  if (hooks_.event) hooks_.event(id, text);
}

}  // namespace tactbench::bench
