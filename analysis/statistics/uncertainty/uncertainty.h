// Uncertainty budgets of compensated pressures, by JCGM 100 (GUM). Dataset + models + the reference's calibration in;
// u_c, effective degrees of freedom, k and U for every taxel, level and branch out. Measurand: the pressure on a taxel
// from one compensated frame, where a full sweep passes a level. Model (4.1.1): p = f(v + d_noise + d_step + d_zero +
// d_creep + d_temperature) + d_repeat + d_model + d_mount
//              + d_certificate + d_drift + d_digit + d_uniformity,   f: the inverse of the branch [Eqs (29)-(39)]
// Every d has the expectation 0 and is taken as independent; c = 1 but for voltages, whose c is the inverse's slope.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "analysis/statistics/figures/creep_effect.h"
#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/numbers/coverage.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "analysis/statistics/uncertainty/temperature_effect.h"

namespace tactbench::analysis {

enum class UncertaintySource {
  kCertificate,
  kDrift,
  kReferenceDigit,
  kUniformity,
  kRepeatability,
  kNoise,
  kConverterStep,
  kModel,
  kZeroReturn,
  kCreep,
  kTemperature,
  kMounting,
};
inline constexpr std::size_t kUncertaintySources = 12;

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
};
struct UncertaintyInputs {
  std::optional<GivenUncertainty> uniformity;  // the chamber's pressure over the array
  std::optional<GivenUncertainty> mounting;    // between mounts
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
};

struct Budget {
  int taxel = -1;
  double pressure_psi = 0.0;
  bool up = true;
  double error_psi = 0.0;                   // mean of the readings - reference: in the model's residual, not corrected
  std::size_t readings = 0;                 // that repeatability rests on
  std::vector<Contribution> contributions;  // the assessed ones, in the order of the sources
  double combined_psi = 0.0;                // u_c, Eq. (10)
  double dof = kInfiniteDof;                // Eq. (G.2b)
  double factor = 2.0;                      // k = t_95.45(dof), G.3.2
  double expanded_psi = 0.0;                // U = k u_c, Eq. (18)
  // False: within +-2 u of the voltage the inverse's slope changes by more than a quarter and the voltage's part of the
  // variance is above a tenth, or the curve ends there: Eq. (10) is then no good approximation (5.1.2, note).
  bool linear = true;
};

struct LevelUncertainty {
  double pressure_psi = 0.0;
  bool up = true;
  std::vector<double> expanded_psi;  // taxels; NaN where not fitted
  Budget median, worst;              // of the taxel with the median U (the lower of two) and the largest
  int not_linear = 0;                // taxels
};

struct Uncertainty {
  ReferenceUncertainty reference;
  std::vector<LevelUncertainty> levels;                  // up by rising pressure, then down; only levels with readings
  std::array<std::string, kUncertaintySources> missing;  // why a source is not assessed; empty: it is
  std::array<std::string, kUncertaintySources> from;     // where a given figure comes from
  CreepEffect creep;
  TemperatureEffect temperature;
  std::size_t chosen = 0;  // the level whose budgets are printed: mid range, down
  [[nodiscard]] const LevelUncertainty* level(double pressure_psi, bool up) const;
};

// One budget, as in assess_uncertainty: for tests and for further levels. `reading` is one of `errors.levels`; the
// level's index within its branch counts for the model's residual.
class BudgetMaker {
 public:
  BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
              const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs);
  [[nodiscard]] Budget budget(std::size_t taxel, std::size_t level) const;
  [[nodiscard]] const std::array<std::string, kUncertaintySources>& missing() const { return missing_; }

 private:
  void find_missing(const Dataset& dataset);
  void add(Budget& budget, UncertaintySource source, double width, double divisor, double sensitivity = 1.0,
           double dof = kInfiniteDof) const;
  void add_reference(Budget& budget) const;
  void add_voltages(Budget& budget, std::size_t taxel) const;
  void add_readings(Budget& budget, std::size_t taxel, std::size_t level) const;
  void add_given(Budget& budget) const;
  void finish(Budget& budget) const;
  [[nodiscard]] double mean_error(std::size_t level, std::size_t taxel) const;
  [[nodiscard]] bool assessed(UncertaintySource source) const;

  const SensorModel& fit_;
  const SweepErrors& errors_;
  const ReferenceUncertainty& reference_;
  const UncertaintyInputs& inputs_;
  std::vector<double> noise_v_;
  double noise_dof_ = 0.0, step_v_ = 0.0;
  std::array<std::string, kUncertaintySources> missing_;
};

// Throws as evaluate(). `dataset` is the run that the models were made from, or another of the same sensor.
Uncertainty assess_uncertainty(const Dataset& dataset, const SensorModel& fit, const db::RunRecord& run,
                               const UncertaintyInputs& inputs = {}, int threads = 0);

}  // namespace tactbench::analysis
