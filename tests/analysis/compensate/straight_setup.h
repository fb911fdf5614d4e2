// A dynamic model of one taxel and one interval, a straight film: 60 psi are 6 V above 0.5 V, up and down. And the
// noise that frames add.
#pragma once

#include <cmath>

#include "analysis/compensate/dynamic_compensator.h"

namespace tactbench::analysis {

inline DynamicSetup straight_setup(double noise_v = 0.0) {
  DynamicSetup setup;
  setup.x_high = 60.0;
  setup.intervals = 1;
  setup.volts_per_count = 1e-4;
  DynamicTaxel taxel;
  taxel.usable = true;
  taxel.divider.zero = 0.5;
  taxel.everett = {0.0, 6.0, 0.0};
  taxel.noise_v = noise_v;
  setup.taxels.push_back(taxel);
  return setup;
}

// With the noise that a frame compensator takes: rounding to counts is noise, too.
inline DynamicSetup with_rounding(DynamicSetup setup) {
  for (DynamicTaxel& taxel : setup.taxels)
    taxel.noise_v = std::hypot(taxel.noise_v, setup.volts_per_count / std::sqrt(12.0));
  return setup;
}

}  // namespace tactbench::analysis
