// The simulated regulator and chamber: finite speed, overshoot, resolution and the regulator's own hysteresis. Pure
// physics in process time.
#pragma once

#include "bench/config/plant_options.h"
#include "devices/units.h"

namespace tactbench::bench {

struct ChamberFaults {                  // faults that are active
  bool valve_shut = false;              // neither fills nor exhausts, whatever is commanded
  double no_supply_fall_psi_per_s = 0;  // above 0: cannot fill, and loses pressure through the valve at this rate
  double leak_psi_per_s = 0.0;          // in addition to that of the options
};

class Chamber {
 public:
  explicit Chamber(const ChamberOptions& options) : options_(options) {}
  void command(devices::Volts volts);  // 0-10 V, clipped to that range
  void dump(bool open) { dump_open_ = open; }
  void set_faults(const ChamberFaults& trouble) { trouble_ = trouble; }
  // From now on the regulator aims `psi` beyond its target (negative: below), until it reaches that or for at most 2 s.
  void overshoot(double psi);
  void advance(double seconds);  // fixed inner step; seconds of any size
  // The true pressure.
  [[nodiscard]] devices::Psi pressure() const { return devices::Psi(pressure_psi_); }
  // The pressure that the regulator measures and controls; the true one differs by up to half of its hysteresis.
  [[nodiscard]] devices::Psi believed() const { return devices::Psi(believed_psi_); }
  [[nodiscard]] const ChamberOptions& options() const { return options_; }

 private:
  void step(double seconds);
  ChamberOptions options_;
  ChamberFaults trouble_;
  bool dump_open_ = false;
  double beyond_psi_ = 0.0;
  double beyond_s_ = 0.0;
  double target_psi_ = 0.0;
  double believed_psi_ = 0.0;
  double rate_psi_per_s_ = 0.0;
  double lead_psi_ = 0.0;  // stop operator of the regulator's hysteresis: true minus measured pressure
  double pressure_psi_ = 0.0;
};

}  // namespace tactbench::bench
