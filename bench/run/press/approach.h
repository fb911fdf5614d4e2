// Finds the specimen's surface with the force sensor: moves down at constant speed until a force is measured, backs
// off, then moves down in small steps, so that backlash is removed on the loading side and the point of contact is
// known to one step.
#pragma once

#include "bench/run/press/press_axis.h"

namespace tactbench::bench {

struct ContactPoint {
  double z_mm = 0.0;                // where the force begins, extrapolated from the last two readings
  double uncertainty_mm = 0.0;      // half a step plus the distance extrapolated
  double coarse_z_mm = 0.0;         // where the first touch ended
  double max_force_n = 0.0;         // greatest force of the approach, including the first touch
  double stiffness_n_per_mm = 0.0;  // at contact
  ForceSample reading;              // reading at the present z, one or two steps after contact
};

// Searches from `clear_z_mm`, which z approaches at travel speed, or from its position when that is nearer to the
// specimen. Throws TB-PRESS-NO-CONTACT (searched to the deepest z), TB-PRESS-NOT-FREE (a force at the start, or still
// after backing off), TB-PRESS-SIGN (the force has the opposite sign while pressing: a servo would run away),
// TB-PRESS-NOT-HOMED and the faults of stage and sensor. Time is bounded by the distance at approach speed.
[[nodiscard]] ContactPoint find_contact(PressAxis& axis, double clear_z_mm);

}  // namespace tactbench::bench
