// The guard's rules for the stage.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/guard/guard.h"

namespace tactbench::bench {

using devices::Axis;

namespace {

constexpr const char* kNames[] = {"stage x", "stage y", "stage z"};
constexpr const char* kRecipe = "Correct the recipe; the limits in the bench file are those of the rig.";

const char* name(Axis axis) { return kNames[static_cast<std::size_t>(axis)]; }

}  // namespace

void Guard::check_move(Axis axis, double target_mm, double speed_mm_per_s, const ReadAxis& read) {
  const AxisLimits& limits = limits_.axes[static_cast<std::size_t>(axis)];
  const std::string asked = fmt::format("a move to {:g} mm at {:g} mm/s", target_mm, speed_mm_per_s);
  const bool in_range = target_mm >= limits.low_mm && target_mm <= limits.high_mm;
  if (!in_range || !(speed_mm_per_s > 0.0 && speed_mm_per_s <= limits.speed_mm_per_s)) {
    refuse("TB-STAGE-LIMIT", name(axis), asked,
           fmt::format("allowed is {:g} to {:g} mm at up to {:g} mm/s", limits.low_mm, limits.high_mm,
                       limits.speed_mm_per_s),
           kRecipe);
  }
  const bool deep = axis == Axis::kZ && target_mm > limits_.safety.clear_z_mm;
  const bool loads = deep && (trip_ || limits_.has_force || moving_[0] || moving_[1]);
  const bool away = axis == Axis::kZ && (trip_ || loads) && target_mm <= read(axis).position.value();
  check_open(name(axis), asked, away);
  if (loads && !away) {
    if (moving_[0] || moving_[1]) {
      refuse("TB-STAGE-ENVELOPE", name(axis), asked,
             fmt::format("x or y moves, and beyond {:g} mm they must be at rest", limits_.safety.clear_z_mm),
             "Wait for the end of the move first; [limits] clear_z_mm.");
    }
    if (limits_.has_force) check_fresh("TB-FORCE-STALE", name(axis), asked, "force sensor, tared,", force_time_);
  }
  if (axis != Axis::kZ) check_clear(axis, asked, read(Axis::kZ));
  log(name(axis), asked, true);
}

void Guard::check_home(Axis axis, const ReadAxis& read) {
  check_open(name(axis), "homing", axis == Axis::kZ);
  if (axis != Axis::kZ) check_clear(axis, "homing", read(Axis::kZ));
  log(name(axis), "homing", true);
}

void Guard::check_clear(Axis axis, const std::string& asked, const devices::AxisState& z) const {
  const double clear = limits_.safety.clear_z_mm;
  const auto refuse_for = [&](const std::string& why, const char* remedy) {
    refuse("TB-STAGE-ENVELOPE", name(axis), asked, why, remedy);
  };
  if (!z.homed) refuse_for("z was not homed, so it may be in contact", "Home z before x and y.");
  if (moving_[2] || z.activity != devices::Activity::kIdle) refuse_for("z moves", "Wait until z is at rest.");
  if (!(z.position.value() <= clear)) {
    refuse_for(fmt::format("z is at {:.2f} mm, beyond {:g} mm", z.position.value(), clear),
               "Retract z first; [limits] clear_z_mm.");
  }
  if (force_time_ < devices::Nanoseconds(0) || force_n_ < limits_.safety.contact_n) return;
  refuse_for(
      fmt::format("the last force reading was {:.2f} N, in contact from {:g} N", force_n_, limits_.safety.contact_n),
      "Retract z and read the force again; [limits] contact_n.");
}

}  // namespace tactbench::bench
