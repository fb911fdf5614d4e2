// U of one compensated reading by condition of use: for each kind of pressure history that held-out runs went through,
// and for each other state of the sensor in which they were made. A kind is named after what was observed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

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

}  // namespace tactbench::analysis
