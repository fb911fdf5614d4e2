// The simulated regulator and chamber: finite speed, overshoot, resolution and the regulator's own hysteresis. Pure
// physics in process time.
#pragma once

#include "devices/units.h"

namespace tactbench::bench {

struct ChamberOptions {
  double span_psi = 130.534;          // regulator, command and monitor: 9 bar for 10 V
  double reference_span_psi = 100.0;  // reference transducer: psi for 10 V
  double time_constant_s = 0.12;      // chamber behind the valve, second order
  double damping = 0.75;              // < 1 overshoots
  double slew_psi_per_s = 60.0;       // valve flow limit
  double resolution_v = 0.002;        // of the command as the regulator sees it
  double hysteresis_share = 0.002;    // regulator's own, as a share of its span (up to 0.005): its sensor lags, so the
                                      // pressure runs ahead of what it believes by half of it on each side
  double leak_psi_per_s = 0.0;        // a defect: pressure lost while held; the regulator makes up for it but for an
                                      // offset of 2 * damping * time constant * leak
  double dump_psi_per_s = 300.0;      // through the open dump valve, more than the regulator can fill
  double reference_noise_psi = 0.01;  // transducer's noise, standard deviation
  double feedback_noise_psi = 0.02;
};

struct ChamberTrouble {                 // what is broken at present
  bool valve_shut = false;              // neither fills nor exhausts, whatever is commanded
  double no_supply_fall_psi_per_s = 0;  // above 0: cannot fill, and loses that much backward through the valve
  double leak_psi_per_s = 0.0;          // beside that of the options
};

class Chamber {
 public:
  explicit Chamber(const ChamberOptions& options) : options_(options) {}
  void command(devices::Volts volts);  // 0-10 V, clipped there
  void dump(bool open) { dump_open_ = open; }
  void set_trouble(const ChamberTrouble& trouble) { trouble_ = trouble; }
  // From now on the regulator aims `psi` beyond its target (negative: below), for at most 2 s or until it is there.
  void overshoot(double psi);
  void advance(double seconds);  // fixed inner step; seconds of any size
  // The truth.
  [[nodiscard]] devices::Psi pressure() const { return devices::Psi(pressure_psi_); }
  // What the regulator believes and controls; the truth is up to half of its hysteresis away.
  [[nodiscard]] devices::Psi believed() const { return devices::Psi(believed_psi_); }
  [[nodiscard]] const ChamberOptions& options() const { return options_; }

 private:
  void step(double seconds);
  ChamberOptions options_;
  ChamberTrouble trouble_;
  bool dump_open_ = false;
  double beyond_psi_ = 0.0;
  double beyond_s_ = 0.0;
  double target_psi_ = 0.0;
  double believed_psi_ = 0.0;
  double rate_psi_per_s_ = 0.0;
  double lead_psi_ = 0.0;  // stop operator of the regulator's own hysteresis: truth minus belief
  double pressure_psi_ = 0.0;
};

}  // namespace tactbench::bench
