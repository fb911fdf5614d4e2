// One budget, as in assess_uncertainty: for tests and for further levels.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "analysis/statistics/figures/history_errors.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::analysis {

inline constexpr double kHeldS = 20.0;  // frames later than this after the command are of held pressures

// Runs made under a condition of use: what readings err by there.
struct Evidence {
  std::vector<FrameErrors> runs;
  HistoryErrors pooled;
  // What U of the others, without the reference's part, would have to be multiplied by to hold 95.45 % of each run, and
  // of all of them: the scale of U. Of runs that each have another; else empty, and 1.
  std::vector<double> needed;
  double scale = 1.0;
};

// What further runs, and the calibration's own inner branches, tell of readings that are no full sweep.
struct HistoryFindings {
  LevelCorrections corrections;                  // mean errors of the full sweeps
  HistoryErrors fitted;                          // inner branches of the calibration itself
  std::array<Evidence, kUseConditions> made_in;  // held-out runs, by condition
  DwellEffect dwell;
};

class BudgetMaker {
 public:
  BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
              const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs, int threads = 0);
  // `level` is the index of one of `errors.levels`.
  [[nodiscard]] Budget budget(std::size_t taxel, std::size_t level,
                              UseCondition condition = UseCondition::kStated) const;
  [[nodiscard]] const std::array<std::string, kUncertaintySources>& missing() const { return missing_; }
  [[nodiscard]] const HistoryFindings& histories() const { return histories_; }
  // Why U does not cover a condition; empty: it does.
  [[nodiscard]] std::string not_valid(UseCondition condition) const;
  // Of U under a condition, without the reference's part: from runs that it was not found from; 1 without such runs.
  [[nodiscard]] double scale_of(UseCondition condition) const;
  // Runs and ranges that U under the condition rests on.
  [[nodiscard]] std::string basis(UseCondition condition) const;

 private:
  void find_missing(const Dataset& dataset);
  void find_histories(const Dataset& dataset, int threads);
  void find_common();
  void find_excess();
  void find_scales(int threads);
  void add(Budget& budget, UncertaintySource source, double width, double divisor, double sensitivity = 1.0,
           double dof = kInfiniteDof, double common = 0.0) const;
  void add_reference(Budget& budget) const;
  void add_voltages(Budget& budget, std::size_t taxel, UseCondition condition) const;
  [[nodiscard]] double zero_return_u(std::size_t taxel) const;  // V
  void add_readings(Budget& budget, std::size_t taxel, std::size_t level) const;
  void add_dwell(Budget& budget, std::size_t taxel, std::size_t level) const;
  void add_history(Budget& budget, std::size_t taxel, std::size_t level, UseCondition condition,
                   const HistoryErrors* history) const;
  void add_given(Budget& budget, std::size_t level, UseCondition condition) const;
  void finish(Budget& budget, double scale) const;
  [[nodiscard]] const Evidence& made_in(UseCondition condition) const;
  // Runs made under the condition are enough to say what readings err by there; else its rows are put together.
  [[nodiscard]] bool told_by_runs(UseCondition condition) const;
  [[nodiscard]] UseCondition scaled_by(UseCondition condition) const;  // whose runs tell the scale
  void find_scale(UseCondition condition, int threads);
  // Standard deviation of the U that runs made under a condition need, as a logarithm; NaN where no two are alike.
  [[nodiscard]] double scatter_of_runs(UseCondition condition) const;
  // All rows but that of the history, which `add_history` takes from `history`.
  [[nodiscard]] Budget without_history(std::size_t taxel, std::size_t level, UseCondition condition) const;
  [[nodiscard]] const HistoryErrors* history_of(UseCondition condition) const;  // null: none
  [[nodiscard]] double excess_psi2(const Budget& budget, std::size_t level) const;
  [[nodiscard]] double mean_error(std::size_t level, std::size_t taxel) const;
  [[nodiscard]] bool assessed(UncertaintySource source) const;

  const SensorModel& fit_;
  const SweepErrors& errors_;
  const ReferenceUncertainty& reference_;
  const UncertaintyInputs& inputs_;
  HistoryFindings histories_;
  std::vector<double> common_scatter_;  // levels: share of the scatter between sweeps that is common to the taxels
  // What full sweeps of repeated runs err by beyond what this run's own tell: variance over the latter, pooled over the
  // taxels, and its degrees of freedom. By level; empty: no repeated run.
  struct Excess {
    double ratio = 0.0, dof = 1.0, common = 0.0;
  };
  std::vector<Excess> excess_;
  std::vector<double> noise_v_;
  double noise_dof_ = 0.0, step_v_ = 0.0;
  std::array<std::string, kUncertaintySources> missing_;
};

}  // namespace tactbench::analysis
