// Streaming inverse of a Preisach model on the linearised output, creep and lag undone, for one taxel: voltages and
// times in, pressures out. Direction, averaging and unknown starts are those of TaxelCompensator; this is the plain
// form: DynamicFrameCompensator computes the same for whole frames, and is tested against it.
#pragma once

#include "analysis/compensate/compensator.h"
#include "analysis/compensate/dynamic_setup.h"
#include "analysis/compensate/everett.h"

namespace tactbench::analysis {

class DynamicTaxelCompensator {
 public:
  // At rest at the lowest pressure. Keeps a reference to `setup`. Throws std::invalid_argument as check_setup and
  // check_taxel.
  DynamicTaxelCompensator(const DynamicSetup& setup, std::size_t taxel);
  // `seconds` since the sample before (0: not known, creep and lag stand still). Throws std::invalid_argument when a
  // value is not finite or seconds is negative; the state is then as before.
  Compensated step(double volts, double seconds);
  // The pressure went to and fro over its whole range for so long, unseen, and came to rest at the lowest:
  // conditioning. Lag and creep follow. Throws std::invalid_argument when the time is negative or not finite.
  void work(double seconds);
  void reset();
  // As reset(), but the film rested at the lowest pressure for only so long: creep and lag went on. Throws as work().
  void rest(double seconds);
  void reset_unknown();  // as TaxelCompensator
  [[nodiscard]] double gain() const { return gain_; }
  [[nodiscard]] bool ascending() const { return ascending_; }

 private:
  struct Reading {
    double x = 0.0, slope = 0.0;  // intervals; intervals a volt
  };
  void follow(double output);
  void take_extreme();
  void decide_when_beyond();
  void turn_when_beyond();
  void turn(Staircase<double>& memory, double output);
  void observe_top();
  void settle_history(Compensated& result);
  [[nodiscard]] double residual() const;  // psi, of the model at the last reading
  [[nodiscard]] double extreme() const;
  [[nodiscard]] double behind_extreme() const;
  [[nodiscard]] double squared_noise(double noises) const;
  [[nodiscard]] double linear(double output) const { return divider_.linear(output); }
  [[nodiscard]] Reading reading(const Staircase<double>& memory, double output) const;
  [[nodiscard]] double sensitivity(const Staircase<double>& memory) const;
  [[nodiscard]] Compensated read(const Staircase<double>& memory, Reading& here) const;

  const DynamicSetup* setup_;
  const DynamicTaxel* taxel_;
  CompensatorOptions options_;
  Divider divider_;  // zero 0: outputs count from the unloaded one
  Everett<double> everett_;
  double per_interval_, top_;  // psi an interval; full output
  Staircase<double> memory_, other_;
  bool unknown_ = false, started_ = true, decided_ = true, ascending_ = true, held_ = true;
  double steps_ = 0.0, mean_ = 0.0, weight_ = 1.0, extreme_ = 0.0, extreme_weight_ = 1.0;
  double gain_ = 1.0, highest_ = 0.0;
  DynamicsState dynamics_;
  double last_x_ = 0.0, last_slope_ = 0.0, last_output_ = 0.0, last_factor_ = 1.0;
};

}  // namespace tactbench::analysis
