// The simulated regulator and chamber: finite speed, overshoot, resolution and the regulator's own hysteresis. Pure
// physics in process time.
#pragma once

#include "devices/units.h"

namespace tactbench::bench {

struct ChamberOptions {
  double span_psi = 130.534;           // 9 bar for 10 V
  double time_constant_s = 0.12;       // chamber behind the valve, second order
  double damping = 0.75;               // < 1 overshoots
  double slew_psi_per_s = 60.0;        // valve flow limit
  double resolution_v = 0.002;         // of the command as the regulator sees it
  double hysteresis_share = 0.002;     // regulator's own, as a share of its span (up to 0.005): the pressure lags the
                                       // command by half of it on each side
  double leak_psi_per_s = 0.0;         // a defect: pressure lost while held
  double reference_noise_psi = 0.01;   // transducer's noise, standard deviation
  double feedback_noise_psi = 0.02;
};

class Chamber {
 public:
  explicit Chamber(const ChamberOptions& options) : options_(options) {}
  void command(devices::Volts volts);
  void advance(double seconds);        // fixed inner step; seconds of any size
  [[nodiscard]] devices::Psi pressure() const { return devices::Psi(pressure_psi_); }
  // What the regulator believes (its sensor has the hysteresis, the chamber has the truth).
  [[nodiscard]] devices::Psi believed() const;
  [[nodiscard]] const ChamberOptions& options() const { return options_; }

 private:
  ChamberOptions options_;
  double target_psi_ = 0.0;
  double pressure_psi_ = 0.0;
  double rate_psi_per_s_ = 0.0;
  double lag_psi_ = 0.0;               // play operator of the regulator's own hysteresis
};

}  // namespace tactbench::bench
