#include "analysis/compensate/options.h"

#include <cmath>
#include <stdexcept>

namespace tactbench::analysis {

void check_options(const CompensatorOptions& options) {
  if (!(options.noise_v >= 0.0 && std::isfinite(options.noise_v)))
    throw std::invalid_argument("compensator: the noise is negative or not a finite number");
  for (const double option :
       {options.moving, options.jump_in_noises, options.lead_in_noises, options.band_in_noises, options.rest_in_noises,
        options.hold_in_noises, options.flat_in_noises, options.flat_psi, options.drift_share, options.known_psi})
    if (!(option >= 0.0 && option <= 1e9))
      throw std::invalid_argument("compensator: an option is negative, above 1e9 or not a number");
  if (options.longest_mean < 1) throw std::invalid_argument("compensator: longest_mean is below 1");
}

}  // namespace tactbench::analysis
