#include "bench/run/press/force_servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/common/process_time.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;

namespace {

constexpr double kAhead = 0.15;  // share by which stiffness may grow over the force range of its measurement
constexpr double kStiffening =
    0.5;  // assumed exponent of stiffness over force while it is not known: F ~ depth^2, cloth
constexpr double kMostStiffening = 0.7;
constexpr double kFar = 1.3;             // times the force measured at: beyond, the exponent is at least
constexpr double kFarStiffening = 0.25;  // this one,
constexpr double kVeryFar = 2.0;         // and from here on at least
constexpr double kVeryFarStiffening = 0.4;
constexpr double kMostAim = 3.0;      // times the present force: loading goes no further in one step
constexpr double kToldBy = 5.0;       // an exponent needs changes of force this many times those for a stiffness
constexpr double kTurnCaution = 1.4;  // a new direction starts up to this much stiffer than the old one ended
constexpr double kTurned = 2.0;       // times the play: travel after a turn with small steps
constexpr double kLeastOfLeft = 0.3;  // the first steps after a turn aim for at least this share of the remaining force
constexpr double kGrowth = 3.0;       // a step is at most this many times the one before
constexpr double kMostIdle = 0.5;     // largest share of a step assumed lost to play
constexpr double kPlayLowers = 0.7;   // a step with play lowers the stiffness to at least this share

}  // namespace

void ForceServo::begin(const ContactPoint& contact) {
  contact_z_mm_ = contact.z_mm;
  stiffness_ = contact.stiffness_n_per_mm;
  span_n_ = stiffness_ * axis_.options().fine_step_mm;
  seen_at_n_ = std::max(axis_.options().contact_n, contact.reading.force_n);
  power_ = kStiffening;
  since_turn_mm_ = kTurned * axis_.options().play_mm;  // the approach has removed the play
  branch_ = Branch::kLoading;
}

void ForceServo::turn(Branch branch, double force_n) {
  last_step_mm_ = 0.0;
  if (branch == branch_) return;
  branch_ = branch;
  since_turn_mm_ = 0.0;
  turned_at_n_ = force_n;
  power_ = kStiffening;
}

double ForceServo::step(double force_n, double target_n, double left_n) const {
  const PressOptions& options = axis_.options();
  // While unloading the contact becomes softer, so that the measured stiffness is on the safe side.
  double caution = 1.0 + kAhead * std::min(1.0, left_n / span_n_);
  if (branch_ == Branch::kLoading) {
    const double aim_n = std::min(target_n, kMostAim * std::max(force_n, options.contact_n));
    left_n -= target_n - aim_n;
    const double growth = std::max(1.0, (force_n + aim_n) / 2.0 / seen_at_n_);
    const double floor = growth > kVeryFar ? kVeryFarStiffening : growth > kFar ? kFarStiffening : 0.0;
    caution *= std::pow(growth, std::max(power_, floor));
  }
  if (since_turn_mm_ < kTurned * options.play_mm) {
    caution = std::max(caution, kTurnCaution);
    // The force that friction may still release suddenly.
    const double drop_n = options.turn_drop_share * turned_at_n_ - std::abs(force_n - turned_at_n_);
    left_n = std::max(left_n - std::max(0.0, drop_n), kLeastOfLeft * left_n);
  }
  double step = left_n / (caution * stiffness_);
  if (last_step_mm_ > 0.0) step = std::min(step, kGrowth * last_step_mm_);
  return std::max(step, options.resolution_mm);
}

void ForceServo::learn(const ForceSample& before, const ForceSample& after) {
  const PressOptions& options = axis_.options();
  const double sign = branch_ == Branch::kLoading ? 1.0 : -1.0;
  const double way = sign * (after.z_mm - before.z_mm);
  const double change = sign * (after.force_n - before.force_n);
  const bool play = since_turn_mm_ < options.play_mm;
  const bool turning = since_turn_mm_ < kTurned * options.play_mm;
  since_turn_mm_ += way;
  last_step_mm_ = way;
  if (change < options.answer_n || !(way > 0.0)) {
    // The force changed less than expected for so small a step: the contact is softer.
    const bool softer = !play && way * stiffness_ > 2.0 * options.answer_n;
    if (softer) stiffness_ = std::max(options.softest_n_per_mm, stiffness_ / 2.0);
    return;
  }
  // The part of the way that play may have made ineffective.
  const double idle = play ? std::min(options.play_mm, kMostIdle * way) : 0.0;
  const double seen = std::clamp(change / (way - idle), options.softest_n_per_mm, options.stiffest_n_per_mm);
  const double at_n = std::max(options.contact_n, (before.force_n + after.force_n) / 2.0);
  if (!turning && std::min(span_n_, change) > kToldBy * options.answer_n && at_n > 1.1 * seen_at_n_) {
    power_ = std::clamp(std::log(seen / stiffness_) / std::log(at_n / seen_at_n_), 0.0, kMostStiffening);
  }
  stiffness_ = play ? std::max(seen, kPlayLowers * stiffness_) : seen;
  span_n_ = change;
  seen_at_n_ = at_n;
}

void ForceServo::check_bounds(double target_n, double force_n, int moves, Nanoseconds deadline) const {
  const PressOptions& options = axis_.options();
  if (moves < options.max_moves && axis_.clock().now() < deadline) return;
  throw Fault("TB-PRESS-TIMEOUT", "stage z",
              fmt::format("{:.2f} N was not reached within {} moves and {:g} s; last reading {:.2f} N at {:.3f} mm, "
                          "{:.1f} N/mm",
                          target_n, options.max_moves, options.level_timeout_s, force_n, axis_.z_mm(), stiffness_));
}

double ForceServo::next_z(double target_n, double force_n, double step_mm, Branch branch) const {
  const PressOptions& options = axis_.options();
  const bool loading = branch == Branch::kLoading;
  const double low = std::max(0.0, contact_z_mm_ - options.clear_mm);
  const double high = std::min(options.max_z_mm, contact_z_mm_ + options.max_press_mm);
  const double z_mm = std::clamp(axis_.z_mm() + (loading ? step_mm : -step_mm), low, high);
  const double onward_mm = loading ? z_mm - axis_.z_mm() : axis_.z_mm() - z_mm;
  if (onward_mm > options.resolution_mm / 2.0) return z_mm;
  throw Fault("TB-PRESS-NO-FORCE", "stage z",
              fmt::format("{:.2f} N was requested; the force is {:.2f} N at z = {:.3f} mm, {:.3f} mm from the contact, "
                          "and the press may not go beyond {:.3f} mm",
                          target_n, force_n, axis_.z_mm(), axis_.z_mm() - contact_z_mm_, loading ? high : low));
}

ServoResult ForceServo::to(double target_n, Branch branch, double band_n) {
  const PressOptions& options = axis_.options();
  const double sign = branch == Branch::kLoading ? 1.0 : -1.0;
  const Nanoseconds deadline = axis_.clock().now() + seconds(options.level_timeout_s);
  ServoResult result;
  result.reading = axis_.sample(options.level_records);
  turn(branch, result.reading.force_n);
  for (;;) {
    const double force_n = result.reading.force_n;
    const double left_n = sign * (target_n - force_n);
    if (left_n < -options.tolerance(target_n)) result.broken = BranchBroken{target_n, force_n, -left_n};
    if (left_n <= band_n) return result;
    check_bounds(target_n, force_n, result.moves, deadline);
    const double z_mm = next_z(target_n, force_n, step(force_n, target_n, left_n), branch);
    const ForceSample before = result.reading;
    result.reading = axis_.move_to(z_mm, options.servo_mm_per_s);
    ++result.moves;
    learn(before, result.reading);
  }
}

}  // namespace tactbench::bench
