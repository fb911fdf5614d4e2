// Systematic errors of the simulated instruments, drawn once for a bench: the same in all its runs, unknown to drivers
// and models, within what the bench file states. They show whether U holds them.
#pragma once

#include "bench/config/plant_options.h"

namespace tactbench::bench {

class InstrumentErrors {
 public:
  explicit InstrumentErrors(const InstrumentOptions& options);

  // The transducer's element follows the pressure: its hysteresis remembers where it turned.
  void follow(double pressure_psi);
  // Reading less truth, psi. Certificate: a part in zero and one in span, together its u at each pressure. Drift,
  // voltage input and zero: constant. Hysteresis: too little rising, too much falling. Temperature: a drawn share of
  // the limit 5 K and more away from 23 degrees Celsius, linear in between.
  [[nodiscard]] double reference_psi(double pressure_psi, double temperature_c) const;
  // Of the force on the sensor: in span alone, since a tare takes off what is constant.
  [[nodiscard]] double force_n(double force_n) const;
  [[nodiscard]] double thermometer_c() const { return thermometer_c_; }

 private:
  [[nodiscard]] double certificate_u(double pressure_psi) const;

  InstrumentOptions options_;
  double zero_share_ = 0.0, span_share_ = 0.0;  // of the certificate's u, normal
  double constant_psi_ = 0.0, hysteresis_psi_ = 0.0, temperature_psi_ = 0.0;
  double force_share_ = 0.0, thermometer_c_ = 0.0;
  double followed_psi_ = 0.0;
};

}  // namespace tactbench::bench
