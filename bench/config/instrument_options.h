// Limits of the errors of the simulated reference, force sensor and thermometer: what the bench file states about them;
// the errors are drawn within these limits.
#pragma once

#include <cstdint>
#include <vector>

namespace tactbench::bench {

// Standard deviation of what a certificate leaves open, half-widths of the rest.
struct DrawnLimits {
  double certificate_u = 0.0, drift = 0.0, input = 0.0;
};

struct InstrumentOptions {
  std::uint64_t seed = 0;  // makes the instruments of a bench; 0: they have no errors
  // Reference, psi. Certificate: standard deviation at readings, rising, linear in between; one for all, or none.
  std::vector<double> reading_psi, certificate_u_psi;
  DrawnLimits reference;  // certificate_u is not used
  double hysteresis_psi = 0.0, zero_psi = 0.0, temperature_psi = 0.0;
  DrawnLimits force_n;        // at full scale: what does not grow with the force is tared away
  DrawnLimits thermometer_c;  // the same at all temperatures
};

}  // namespace tactbench::bench
