#include "analysis/compensate/options.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

void check_options(const CompensatorOptions& options) {
  for (const double option : {options.noise_v, options.moving, options.jump_in_noises, options.lead_in_noises,
                              options.band_in_noises, options.rest_in_noises, options.hold_in_noises,
                              options.flat_in_noises, options.flat_psi, options.drift_share, options.known_psi})
    if (!std::isfinite(option) || option < 0.0)
      throw std::invalid_argument("compensator: an option is negative or not a finite number");
  if (options.longest_mean < 1) throw std::invalid_argument("compensator: longest_mean is below 1");
}

}  // namespace tactbench::analysis
