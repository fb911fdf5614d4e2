// U of a reading from the errors observed on held-out pressure histories, without an error model or a budget of
// sources. Each history is compared with the U of the others, and U is scaled until it covers 95.45 % of them (JCGM
// 100, G.1.2: k is that of the distribution), as far as three of four such sets of histories would need it. The
// reference's own error, which no run against it can show, is added.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "analysis/statistics/figures/sweep_errors.h"
#include "analysis/statistics/uncertainty/history_kind.h"

namespace tactbench::analysis {

// Further runs of the sensor, not those that models were made from. The datasets outlive the inputs.
struct HistoryRuns {
  std::vector<const Dataset*> same;     // held out: same mount, same day, same temperature
  std::vector<const Dataset*> later;    // held out: another day, or for a simulated sensor another age
  std::vector<const Dataset*> warm;     // held out: same mount, same day, another temperature
  std::vector<const Dataset*> mounted;  // held out, or of a study of mounts: mounted again
  std::vector<const Dataset*> paced;    // candidates for the effect of dwell
};

// Histories observed under one condition. In the state of the calibration each history is one of its kind; in another
// state all histories of a run are one, because they share that state.
struct EmpiricalEvidence {
  std::vector<FrameHistory> histories;
  std::vector<UseCondition> kinds;                                 // of the histories, each once
  std::vector<std::int64_t> runs;                                  // each once
  double arrival_low_s = 0.0, arrival_high_s = 0.0, held_s = 0.0;  // from command to frame: shortest, longest, hold
};

struct EmpiricalErrors {
  std::vector<FrameErrors> runs;  // that the histories point into
  std::array<EmpiricalEvidence, kUseConditions> made_in;
  EmpiricalErrors() = default;
  EmpiricalErrors(EmpiricalErrors&&) = default;
  EmpiricalErrors& operator=(EmpiricalErrors&&) = default;
  [[nodiscard]] const EmpiricalEvidence& in(UseCondition condition) const {
    return made_in[static_cast<std::size_t>(condition)];
  }
};

// Outputs rising (as_modelled). A history is at another dwell where its frames come more than twice as soon or late as
// those of the calibration's sweeps and branches; held pressures are not.
EmpiricalErrors empirical_errors(const Dataset& calibration, const HistoryRuns& history, const SensorModel& fit,
                                 int threads = 0);

// Each UseCondition, in order. `levels`: those of the fit up, then down, as sweep_errors gives them; U is stated where
// there are readings and the reference is known. `unobservable_u_psi`: u of what held-out runs cannot show, at a
// pressure; NaN where it is not known.
std::vector<ConditionUncertainty> empirical_uncertainty(const EmpiricalErrors& counted, const SensorModel& fit,
                                                        const LevelCorrections& corrections,
                                                        std::span<const LevelReadings> levels,
                                                        const std::function<double(double psi)>& unobservable_u_psi);

}  // namespace tactbench::analysis
