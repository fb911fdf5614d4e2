// Systematic errors of the simulated instruments, drawn once for a bench, within the limits that the bench file states:
// the same in all its runs, unknown to drivers and models. They test whether U covers the errors.
#pragma once

#include "bench/config/plant_options.h"

namespace tactbench::bench {

class InstrumentErrors {
 public:
  explicit InstrumentErrors(const InstrumentOptions& options);

  // Updates the transducer's hysteresis with the pressure.
  void follow(double pressure_psi);
  // Reading minus true pressure, psi. Certificate: one part in zero and one in span, together u at each pressure.
  // Drift, voltage input and zero: constant. Hysteresis: too low when rising, too high when falling. Temperature: a
  // drawn share of the limit at 5 K or more from 23 degrees Celsius, linear in between.
  [[nodiscard]] double reference_psi(double pressure_psi, double temperature_c) const;
  // Error of the force: only in span, because taring removes a constant error.
  [[nodiscard]] double force_n(double force_n) const;
  [[nodiscard]] double thermometer_c() const { return thermometer_c_; }

 private:
  [[nodiscard]] double certificate_u(double pressure_psi) const;

  InstrumentOptions options_;
  double zero_share_ = 0.0, span_share_ = 0.0;  // shares of the certificate's u, drawn from a normal distribution
  double constant_psi_ = 0.0, hysteresis_psi_ = 0.0, temperature_psi_ = 0.0;
  double force_share_ = 0.0, thermometer_c_ = 0.0;
  double followed_psi_ = 0.0;
};

}  // namespace tactbench::bench
