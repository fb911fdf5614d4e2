// Finds the specimen's surface with the force sensor: down at constant speed until a force is felt, back off, then in
// small steps, so that play is taken up on the loading side and where contact begins is known to a step.
#pragma once

#include "bench/run/press/press_axis.h"

namespace tactbench::bench {

struct ContactPoint {
  double z_mm = 0.0;                // where the force begins, by the line through the last two readings
  double uncertainty_mm = 0.0;      // half a step and what the line is drawn out by
  double coarse_z_mm = 0.0;         // where the first touch stopped
  double greatest_n = 0.0;          // felt on the way, the first touch included: the specimen's history
  double stiffness_n_per_mm = 0.0;  // at contact
  ForceSample reading;              // where z stands now, a step or two in contact
};

// Searches from `clear_z_mm`, to where z goes at travel speed, or from where it stands when that is nearer. Throws
// TB-PRESS-NO-CONTACT (searched to the deepest z), TB-PRESS-NOT-FREE (a force stands at the start, or stays after
// backing off), TB-PRESS-SIGN (pressing reads with the other sign: a servo would run away), TB-PRESS-NOT-HOMED and
// those of stage and sensor. Bounded by the way at approach speed.
[[nodiscard]] ContactPoint find_contact(PressAxis& axis, double clear_z_mm);

}  // namespace tactbench::bench
