// Parameters of the simulated regulator and chamber.
#pragma once

namespace tactbench::bench {

struct ChamberOptions {
  double low_psi = 0.0, span_psi = 130.534;  // regulator, command and monitor: at 0 V and at 10 V
  double reference_span_psi = 100.0;         // reference transducer: psi for 10 V
  double time_constant_s = 0.12;             // chamber behind the valve, second order
  double damping = 0.75;                     // < 1 overshoots
  double slew_psi_per_s = 60.0;              // valve flow limit
  double resolution_v = 0.002;               // of the command as the regulator sees it
  double hysteresis_share = 0.002;    // regulator's own, as a share of its span (up to 0.005): its sensor lags, so the
                                      // pressure runs ahead of what it believes by half of it on each side
  double leak_psi_per_s = 0.0;        // a defect: pressure lost while held; the regulator compensates it except for an
                                      // offset of 2 * damping * time constant * leak
  double dump_psi_per_s = 300.0;      // through the open dump valve, more than the regulator can fill
  double reference_noise_psi = 0.01;  // transducer's noise, standard deviation
  double feedback_noise_psi = 0.02;
};

}  // namespace tactbench::bench
