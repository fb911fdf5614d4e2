// U of a reading from the errors observed on held-out pressure histories, without an error model or a budget of
// sources; and the kinds of history and conditions of use in which it is valid. The errors of
// each history are compared with the U from the others, and U is scaled so that it covers 95.45 % of the readings of
// the histories left out (JCGM 100, G.1.2). The scale is the one that suffices for three quarters of such sets of
// histories. The reference's own error, which no run against it can show, is added.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

// Classifies the pressure history of a held-out run by its trajectory alone, not by names of recipes; U of one
// compensated reading by condition of use: for each kind of history that held-out runs went through, and for each other
// state of the sensor in which they were made; and where a reading is within a requested error.
enum class UseCondition {
  // In the state of the calibration: same mount, day, temperature and dwell times.
  kFullSweeps,      // from one end of the range to the other
  kReversals,       // over the whole range, after full pressure
  kSmallReversals,  // of a few psi, after full pressure
  kHeld,            // a pressure is held
  // In another state, histories of any of these kinds.
  kOtherDwell,
  kOtherTemperature,
  kRemounted,
  kLater,  // another day
};
inline constexpr std::size_t kUseConditions = 8;
inline constexpr std::size_t kHistoryKinds = 4;  // the first of them
const char* name_of(UseCondition condition);     // "reversals over the whole range after full pressure"

// U under one condition of use. Valid: `not_valid` is empty.
struct ConditionUncertainty {
  UseCondition condition = UseCondition::kFullSweeps;
  std::string name;                // as name_of, with how long pressures were held: "held pressures (up to 20 s)"
  std::string not_valid;           // why U does not cover it: none measured, or "5 histories leave it open by 9 %"
  std::string basis;               // what it rests on, in words
  std::vector<std::int64_t> runs;  // whose histories were counted
  std::size_t histories = 0;       // independent ones that were counted
  std::size_t readings = 0;        // frames of these that were counted
  double factor = kNan;            // k: U² = (2 u of the reference)² + (k x root mean square of the counted errors)²
  double median_psi = kNan;        // of U over all levels and taxels
  // Levels up, then down (those with readings), x taxels; NaN where not fitted. Empty where not valid.
  std::vector<double> pressure_psi;
  std::vector<bool> up;
  std::vector<double> expanded_psi;  // U
  std::vector<double> error_psi;     // mean error of the calibration's full sweeps, known, about which U lies
  [[nodiscard]] bool valid() const { return not_valid.empty(); }
  [[nodiscard]] std::size_t taxels() const {
    return pressure_psi.empty() ? 0 : expanded_psi.size() / pressure_psi.size();
  }
};

// What is taken off a compensated reading, and U of what is left; linear between levels, constant beyond them.
struct ReadingUncertainty {
  double error_psi = 0.0, expanded_psi = 0.0;
};
// Of a valid condition. NaN where the taxel is not fitted, or no level of that direction was counted.
ReadingUncertainty reading_uncertainty(const ConditionUncertainty& condition, std::size_t taxel, double reading_psi,
                                       bool up);

// Of the kinds of history that are valid in the state of the calibration the one with the largest median U: what is
// quoted where one U is quoted.
std::optional<UseCondition> worst_of(std::span<const ConditionUncertainty> conditions);

inline constexpr double kMinHeldS = 5.0;              // a level with several frames over this long is held
inline constexpr double kSmallShare = 0.15;           // of the range: small reversals are no larger in the median, ...
inline constexpr std::size_t kMinSmallReversals = 5;  // ... and not fewer than this
inline constexpr double kWholeShare = 0.5;  // of the range lies between the turning points of "the whole range"

// Of each step the kind that its frame is evidence for; none: for no kind that has a name.
// - A sequence that holds pressures above the lowest: its frames at held levels are kHeld, the others nothing.
// - Else frames of branches over the whole range are kFullSweeps.
// - Frames of inner branches count once full pressure was reached, before the sequence (`pressed`) or in it. Where half
//   of the inner branches are small, kSmallReversals; where the points at which they turn lie far apart, kReversals.
// low < high: the range, psi.
std::vector<std::optional<UseCondition>> history_kinds(const SequenceData& sequence, double low, double high,
                                                       bool pressed);

// The histories of a run that count, by kind; each is independent of the others. A full sweep is one for each repeat of
// its sequence, of other kinds all repeats are one history, because they go the same way. A sequence with the
// set-points of one of `calibration` is evidence for full sweeps alone: its inner branches are those that models were
// fitted to.
struct KindHistories {
  UseCondition kind = UseCondition::kFullSweeps;
  FrameHistory history;
  double arrival_s = 0.0;  // median time from command to a level's first frame; 0: not stated
  double held_s = 0.0;     // longest time from command to a frame
};
std::vector<KindHistories> kind_histories(const Dataset& run, const FrameErrors& errors, const Dataset& calibration,
                                          double low, double high);

// Of fewer of a kind none can be held against U of the others, and U stays open.
inline constexpr std::size_t kLeastHistories = 2;
// How many histories of each kind a run of the sequences `judged` shows at most, as kind_histories() counts them,
// beside models of `calibration`: known from set-points and times of dwell, before anything is measured. Without a
// calibration the range is that of `judged`.
std::array<std::size_t, kHistoryKinds> planned_histories(const std::vector<SequenceData>& judged,
                                                         const std::vector<SequenceData>& calibration);

// 5 and 95 % quantile of the times from command to a level's first frame, above the lowest level; empty: not stated.
struct ArrivalTimes {
  double low_s = 0.0, high_s = 0.0;
};
std::optional<ArrivalTimes> arrival_times(const Dataset& run);

inline constexpr double kMeasuringShare = 0.95;  // of the taxels

struct MeasuringInterval {
  bool any = false;  // false: at no level
  double low_psi = 0.0, high_psi = 0.0;
};

// The longest run of neighbouring levels of one direction at each of which |error| + U of at least `share` of the
// taxels is at most `mpe_psi`; of two as long the lower. `fitted`: taxels that count, those without U as above it.
// None where the condition is not valid, or no level of that direction was counted.
MeasuringInterval measuring_interval(const ConditionUncertainty& condition, bool up, double mpe_psi,
                                     std::span<const std::size_t> fitted, double share = kMeasuringShare);

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
