#include "bench/run/press/approach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "devices/device.h"

namespace tactbench::bench {

using devices::Fault;

namespace {

constexpr int kBackOffs = 4;  // each twice as far as the one before

[[noreturn]] void not_free(const PressAxis& axis, const ForceSample& reading, double limit_n) {
  throw Fault("TB-PRESS-NOT-FREE", "force sensor",
              fmt::format("{:.2f} N at z = {:.3f} mm, where the indenter should not touch anything (below {:g} N)",
                          reading.force_n, axis.z_mm(), limit_n));
}

void check_free(const PressAxis& axis, const ForceSample& reading, double limit_n) {
  if (!(std::abs(reading.force_n) < limit_n)) not_free(axis, reading, limit_n);
}

[[noreturn]] void no_contact(const PressAxis& axis, double from_mm) {
  throw Fault("TB-PRESS-NO-CONTACT", "stage z",
              fmt::format("z went from {:.3f} to {:.3f} mm without {:g} N on the force sensor", from_mm, axis.z_mm(),
                          axis.options().contact_n));
}

// Backs off until the force is gone; the specimen may recover slowly and follow.
void back_off(PressAxis& axis) {
  const PressOptions& options = axis.options();
  double way = options.backoff_mm;
  ForceSample reading;
  for (int i = 0; i < kBackOffs; ++i, way *= 2.0) {
    reading = axis.move_to(std::max(0.0, axis.z_mm() - way), options.servo_mm_per_s);
    if (std::abs(reading.force_n) < options.contact_n / 2.0) return;
  }
  check_free(axis, reading, options.contact_n / 2.0);
}

}  // namespace

ContactPoint find_contact(PressAxis& axis, double clear_z_mm) {
  const PressOptions& options = axis.options();
  const double from_mm = axis.find();
  check_free(axis, axis.sample(options.level_records), options.contact_n);
  if (from_mm < clear_z_mm) {
    // Stops at the first touch of an object that is taller than clear_z allows for.
    const bool touched = axis.descend(clear_z_mm, options.travel_limit_mm_per_s());
    const ForceSample there = axis.sample(options.level_records);
    if (touched) not_free(axis, there, options.contact_n);
    check_free(axis, there, options.contact_n);
  }
  if (!axis.descend(options.max_z_mm, options.approach_mm_per_s)) no_contact(axis, from_mm);
  ContactPoint contact;
  contact.coarse_z_mm = axis.z_mm();
  const ForceSample touch = axis.sample(options.poll_records);
  contact.max_force_n = std::abs(touch.force_n);
  if (touch.force_n < 0.0) {
    throw Fault("TB-PRESS-SIGN", "force sensor",
                fmt::format("on contact Fz reads {:.2f} N, pressing should read {} it", touch.wrench.force_n[2],
                            options.pressing_sign < 0.0 ? "below zero, not above" : "above zero, not below"));
  }
  back_off(axis);

  const double start_mm = axis.z_mm();
  const double last_mm = std::min(contact.coarse_z_mm + options.backoff_mm, options.max_z_mm);
  ForceSample before = axis.sample(options.level_records);
  for (;;) {
    const double z_mm = axis.z_mm() + options.fine_step_mm;
    if (z_mm > last_mm) no_contact(axis, start_mm);
    const ForceSample now = axis.move_to(z_mm, options.servo_mm_per_s);
    contact.max_force_n = std::max(contact.max_force_n, now.force_n);
    // Two successive readings in contact, one step apart: the line through them gives the point of contact.
    const bool twice = before.force_n >= options.contact_n && now.force_n >= options.contact_n;
    if (twice) {
      const double slope = (now.force_n - before.force_n) / (now.z_mm - before.z_mm);
      contact.stiffness_n_per_mm = std::clamp(slope, options.softest_n_per_mm, options.stiffest_n_per_mm);
      const double drawn_out = before.force_n / contact.stiffness_n_per_mm;
      contact.z_mm = before.z_mm - drawn_out;
      contact.uncertainty_mm = options.fine_step_mm / 2.0 + drawn_out;
      contact.reading = now;
      return contact;
    }
    before = now;
  }
}

}  // namespace tactbench::bench
