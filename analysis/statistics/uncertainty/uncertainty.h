// Uncertainty budgets of compensated pressures, by JCGM 100 (GUM). Dataset + models + the reference's calibration in;
// u_c, effective degrees of freedom, k and U for every taxel, level and branch out. Measurand: the pressure on a taxel
// from one compensated frame, corrected for what is known of its error, at any point of its history.
// Model (4.1.1): p = f(v + d_noise + d_step + d_creep + d_temperature + d_zero) - e
//   + d_repeat + d_conditioning + d_fit + d_history + d_dwell + d_mount + d_own
//   + d_certificate + d_drift + d_digit + d_input + d_hysteresis + d_reference's zero and temperature
//   + d_uniformity,   f: the inverse of the branch [Eqs (29)-(39)]
// Every d has the expectation 0 and is assumed independent; c = 1 except for voltages, whose c is the inverse's slope.
// e, the mean error of the full sweeps at the level and half of creep's effect, is known and taken off (3.2.3, 6.3.1).
// The budgets say where U comes from. The U quoted for a reading is not theirs: it is counted from observed errors, one
// U for each kind of pressure history (empirical_errors.h).
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/empirical_errors.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"

namespace tactbench::analysis {

enum class UncertaintySource {
  kCertificate,
  kDrift,
  kReferenceDigit,
  kReferenceInput,
  kReferenceHysteresis,
  kReferenceZero,
  kReferenceTemperature,
  kUniformity,
  kRepeatability,
  kNoise,
  kConverterStep,
  kModel,
  kZeroReturn,
  kCreep,
  kTemperature,
  kMounting,
  kMountingPerTaxel,
  kConditioning,
  kDwell,
  kHistory,
};
inline constexpr std::size_t kUncertaintySources = 20;

struct SourceText {
  const char* name;
  char type;                 // 'A' by statistics of this run (4.2), 'B' by other knowledge (4.3)
  const char* distribution;  // normal | Student | rectangular
  const char* unit;          // of `width`: psi | V
  const char* width;         // what `width` is: "U of the certificate", "half-width", "s"
  const char* basis;         // how it is determined, and the clause of the GUM
};
const SourceText& text_of(UncertaintySource source);

// A standard uncertainty that comes from other runs: u(p)² = psi² + (share x p)².
struct GivenUncertainty {
  double psi = 0.0, share = 0.0;
  double dof = kInfiniteDof;
  std::string from;  // "runs 4 to 7, the sensor turned by 90 degrees"
  [[nodiscard]] double u(double pressure_psi) const { return std::hypot(psi, share * pressure_psi); }
};
struct UncertaintyInputs {
  std::optional<GivenUncertainty> uniformity;          // the chamber's pressure over the array
  std::optional<GivenUncertainty> mounting;            // between two mounts, what all taxels have in common
  std::optional<GivenUncertainty> mounting_per_taxel;  // between two mounts, a taxel's own
  HistoryRuns history = {};
  // What moves the output, times the inverse's slope: one share of p would hide where the curve is flat.
  CreepEffect creep = {};                  // of a reading later than the calibration's
  TemperatureEffect temperature = {};      // over the temperatures of the run
  std::vector<InstrumentNote> notes = {};  // of a laboratory file, on the reference
};

// One row of a budget. width / divisor = u(x); sensitivity in psi per unit of width; u_psi = |c| u(x).
struct Contribution {
  UncertaintySource source = UncertaintySource::kCertificate;
  double width = 0.0, divisor = 1.0, sensitivity = 1.0, u_psi = 0.0;
  double dof = kInfiniteDof;
  double common = 0.0;  // share of u_psi² that all taxels have in common
};

struct Budget {
  int taxel = -1;
  double pressure_psi = 0.0;
  bool up = true;
  double error_psi = 0.0;    // e: mean of the readings - reference, and half of creep's effect; taken off
  std::size_t readings = 0;  // that repeatability rests on
  std::vector<Contribution> contributions;  // the assessed ones, in the order of the sources
  double combined_psi = 0.0;                // u_c, Eq. (10)
  double dof = kInfiniteDof;                // Eq. (G.2b)
  double factor = 2.0;                      // k = t_95.45(dof), G.3.2
  double expanded_psi = 0.0;                // U = k u_c, Eq. (18)
  // False: within +-2 u of the voltage the inverse's slope changes by more than a quarter and the voltage's part of the
  // variance is above a tenth, or the curve ends there: Eq. (10) is then no good approximation (5.1.2, note).
  bool linear = true;
  // For users who do not subtract e: reading minus pressure lies between these (6.3.1, note).
  [[nodiscard]] double lower_psi() const { return error_psi - expanded_psi; }
  [[nodiscard]] double upper_psi() const { return error_psi + expanded_psi; }
};

// U of figures of the whole array at a level, from common and own parts; k = t_95.45 of its own degrees of freedom.
struct ArrayUncertainty {
  double mean_u_psi = 0.0, mean_expanded_psi = 0.0;  // mean pressure; total force: times the array's area
  double centre_expanded = 0.0;  // centre of pressure of an evenly loaded array, along rows and columns, in pitches
};

struct LevelUncertainty {
  double pressure_psi = 0.0;
  bool up = true;
  std::vector<double> expanded_psi;  // taxels; NaN where not fitted
  std::vector<double> error_psi;     // taxels: e
  std::vector<double> factor;        // taxels: k
  ArrayUncertainty array;
  Budget median, worst;  // of the taxel with the median U (the lower of two) and the largest
  int not_linear = 0;    // taxels
};

struct Uncertainty {
  ReferenceUncertainty reference;
  std::vector<LevelUncertainty> levels;  // up by rising pressure, then down; with readings, in the certificate's range
  std::array<std::string, kUncertaintySources> missing;  // why a source is not assessed; empty: it is
  std::array<std::string, kUncertaintySources> from;     // where a given figure comes from
  CreepEffect creep;
  TemperatureEffect temperature;
  DwellEffect dwell;
  std::vector<ConditionUncertainty> conditions;                                   // each UseCondition, in order
  [[nodiscard]] const ConditionUncertainty& condition(UseCondition which) const;  // of `conditions`, which has it
  // What is quoted where one U is: worst_of(conditions).
  [[nodiscard]] std::optional<UseCondition> worst() const { return worst_of(conditions); }
  std::size_t chosen = 0;  // the level whose budgets are printed: mid range, down
  [[nodiscard]] const LevelUncertainty* level(double pressure_psi, bool up) const;
};

// Throws as evaluate(). `dataset` is the run that the models were made from, or another of the same sensor.
Uncertainty assess_uncertainty(const Dataset& dataset, const SensorModel& fit, const db::RunRecord& run,
                               const UncertaintyInputs& inputs = {}, int threads = 0);

// Its `conditions` alone, as counted on `history`. `sweeps`: sweep_errors() of `dataset`, which several judged runs
// share.
std::vector<ConditionUncertainty> reading_conditions(const Dataset& dataset, const SensorModel& fit,
                                                     const db::RunRecord& run, const HistoryRuns& history,
                                                     const SweepErrors& sweeps, int threads = 0);

// Makes one uncertainty budget, as assess_uncertainty does: for tests and for further levels.
class BudgetMaker {
 public:
  BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
              const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs, int threads = 0);
  // `level` is the index of one of `errors.levels`.
  [[nodiscard]] Budget budget(std::size_t taxel, std::size_t level) const;
  [[nodiscard]] const std::array<std::string, kUncertaintySources>& missing() const { return missing_; }
  [[nodiscard]] const DwellEffect& dwell() const { return dwell_; }
  [[nodiscard]] const EmpiricalErrors& counted() const { return counted_; }
  [[nodiscard]] const LevelCorrections& corrections() const { return corrections_; }  // mean errors of full sweeps
  // u of the effects that no run of this sensor in this chamber against this reference can show; NaN: not known.
  [[nodiscard]] double unobservable_u_psi(double pressure_psi) const;

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
  EmpiricalErrors counted_;
  std::vector<WindowErrors> reversals_;  // of held-out runs, else of the calibration's own inner branches
  DwellEffect dwell_;
  std::vector<double> common_scatter_;  // levels: share of the scatter between sweeps that is common to the taxels
  std::vector<double> noise_v_;
  double noise_dof_ = 0.0, step_v_ = 0.0;
  std::array<std::string, kUncertaintySources> missing_;
};

}  // namespace tactbench::analysis
