// Makes one uncertainty budget, as assess_uncertainty does: for tests and for further levels.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "analysis/statistics/figures/history_errors.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::analysis {

class BudgetMaker {
 public:
  BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
              const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs, int threads = 0);
  // `level` is the index of one of `errors.levels`.
  [[nodiscard]] Budget budget(std::size_t taxel, std::size_t level) const;
  [[nodiscard]] const std::array<std::string, kUncertaintySources>& missing() const { return missing_; }
  [[nodiscard]] const DwellEffect& dwell() const { return dwell_; }
  [[nodiscard]] const CountedErrors& counted() const { return counted_; }
  [[nodiscard]] const LevelCorrections& corrections() const { return corrections_; }  // mean errors of full sweeps
  // u of the effects that no run of this sensor in this chamber against this reference can show; NaN: not known.
  [[nodiscard]] double hidden_psi(double pressure_psi) const;

 private:
  void find_missing(const Dataset& dataset);
  void find_histories(const Dataset& dataset, int threads);
  void find_common();
  void add(Budget& budget, UncertaintySource source, double width, double divisor, double sensitivity = 1.0,
           double dof = kInfiniteDof, double common = 0.0) const;
  void add_reference(Budget& budget) const;
  void add_voltages(Budget& budget, std::size_t taxel) const;
  [[nodiscard]] double zero_return_u(std::size_t taxel) const;  // V
  void add_readings(Budget& budget, std::size_t taxel, std::size_t level) const;
  void add_dwell(Budget& budget, std::size_t taxel, std::size_t level) const;
  void add_history(Budget& budget, std::size_t taxel) const;
  void add_given(Budget& budget) const;
  void finish(Budget& budget) const;
  [[nodiscard]] bool assessed(UncertaintySource source) const;

  const SensorModel& fit_;
  const SweepErrors& errors_;
  const ReferenceUncertainty& reference_;
  const UncertaintyInputs& inputs_;
  LevelCorrections corrections_;
  CountedErrors counted_;
  std::vector<WindowErrors> reversals_;  // of held-out runs, else of the calibration's own inner branches
  DwellEffect dwell_;
  std::vector<double> common_scatter_;  // levels: share of the scatter between sweeps that is common to the taxels
  std::vector<double> noise_v_;
  double noise_dof_ = 0.0, step_v_ = 0.0;
  std::array<std::string, kUncertaintySources> missing_;
};

}  // namespace tactbench::analysis
