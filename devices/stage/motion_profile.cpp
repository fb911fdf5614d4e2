#include "devices/stage/motion_profile.h"

#include <algorithm>
#include <cmath>

namespace tactbench::devices {

void MotionProfile::add(double duration, double acceleration) {
  if (!(duration > 0.0)) return;
  pieces_.push_back({duration, acceleration});
  duration_ += duration;
}

MotionProfile MotionProfile::to_rest(double position, double velocity, double acceleration) {
  MotionProfile profile(position);
  profile.start_velocity_ = velocity;
  profile.end_ = position + velocity * std::abs(velocity) / (2.0 * acceleration);
  profile.add(std::abs(velocity) / acceleration, std::copysign(acceleration, -velocity));
  return profile;
}

MotionProfile MotionProfile::to(double position, double velocity, double target, double speed, double acceleration) {
  MotionProfile profile(position);
  profile.start_velocity_ = velocity;
  profile.end_ = target;
  const double braking = velocity * std::abs(velocity) / (2.0 * acceleration);
  if ((target - position) * velocity < 0.0 || std::abs(braking) > std::abs(target - position)) {
    // It moves away from the target, or too fast to stop there: first to rest, then back.
    profile.add(std::abs(velocity) / acceleration, std::copysign(acceleration, -velocity));
    position += braking;
    velocity = 0.0;
  }
  const double sign = target >= position ? 1.0 : -1.0;
  double distance = std::abs(target - position);
  double along = std::abs(velocity);
  if (along > speed) {
    profile.add((along - speed) / acceleration, -sign * acceleration);
    distance -= (along * along - speed * speed) / (2.0 * acceleration);
    along = speed;
  }
  // Speed up to v, stay, slow down to rest: v^2 = a d + v0^2 / 2 when `speed` is not reached.
  const double peak = std::min(speed, std::sqrt(std::max(0.0, acceleration * distance + along * along / 2.0)));
  const double used = (2.0 * peak * peak - along * along) / (2.0 * acceleration);
  profile.add((peak - along) / acceleration, sign * acceleration);
  if (peak > 0.0) profile.add((distance - used) / peak, 0.0);
  profile.add(peak / acceleration, -sign * acceleration);
  return profile;
}

double MotionProfile::position(double seconds) const {
  if (seconds >= duration_) return end_;
  double place = start_;
  double velocity = start_velocity_;
  for (const Piece& piece : pieces_) {
    const double span = std::clamp(seconds, 0.0, piece.duration);
    place += (velocity + piece.acceleration * span / 2.0) * span;
    velocity += piece.acceleration * span;
    seconds -= span;
  }
  return place;
}

double MotionProfile::velocity(double seconds) const {
  if (seconds >= duration_) return 0.0;
  double velocity = start_velocity_;
  for (const Piece& piece : pieces_) {
    const double span = std::clamp(seconds, 0.0, piece.duration);
    velocity += piece.acceleration * span;
    seconds -= span;
  }
  return velocity;
}

}  // namespace tactbench::devices
