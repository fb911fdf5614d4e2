// Conditions of use: which of them U covers, on what it rests, and why it does not cover the others.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/budget_maker.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kNoHeldOut =
    "no held-out run with reversals other than the fitted ones: name one of random-reversal";

std::string history_words(const HistoryErrors& history) {
  return fmt::format("{}, frames {:.1f} to {:.1f} s after the command", counted(history.runs.size(), "run"),
                     history.dwell_low_s, history.dwell_high_s);
}

}  // namespace

const char* name_of(UseCondition condition) {
  static constexpr std::array<const char*, kUseConditions> kNames = {"all that was assessed, together",
                                                                     "full sweeps, as calibrated",
                                                                     "inner branches like those of the calibration",
                                                                     "any reversals, as calibrated otherwise",
                                                                     "any reversals, other dwell",
                                                                     "any reversals, held pressures",
                                                                     "any reversals, other temperature",
                                                                     "any reversals, re-mounted",
                                                                     "any reversals, another day"};
  return kNames[static_cast<std::size_t>(condition)];
}

std::string BudgetMaker::not_valid(UseCondition condition) const {
  const auto missing = [this](UncertaintySource source) { return missing_[static_cast<std::size_t>(source)]; };
  if (condition == UseCondition::kStated) return {};
  if (condition == UseCondition::kFullSweeps) return missing(UncertaintySource::kRepeatability);
  if (condition == UseCondition::kFittedBranches)
    return history_of(condition) == nullptr ? "the calibration has no inner branches" : "";
  if (condition == UseCondition::kLater)
    return history_of(condition) == nullptr ? "what time does to the sensor is known from a held-out run of another day"
                                            : "";
  if (history_of(condition) == nullptr) return kNoHeldOut;
  if (condition == UseCondition::kOtherDwell) return missing(UncertaintySource::kDwell);
  if (condition == UseCondition::kHeld) return missing(UncertaintySource::kCreep);
  if (condition == UseCondition::kOtherTemperature) return missing(UncertaintySource::kTemperature);
  if (condition == UseCondition::kRemounted) return missing(UncertaintySource::kMounting);
  return {};
}

std::string BudgetMaker::basis(UseCondition condition) const {
  const HistoryErrors* history = history_of(condition);
  std::string words = history == nullptr ? "the full sweeps of this run" : history_words(*history);
  if (condition == UseCondition::kFittedBranches) words += ", of this run itself, which the models were fitted to";
  if (condition == UseCondition::kFullSweeps || condition == UseCondition::kFittedBranches)
    words += histories_.repeated.known()
                 ? fmt::format("; {} held out of the same sequences", counted(histories_.repeated.runs.size(), "run"))
                 : "; no held-out run of the same sequences: U is too small by what another run differs by";
  if (condition == UseCondition::kOtherDwell)
    words +=
        fmt::format("; one loop at dwell times of {:.1f} to {:.1f} s", histories_.dwell.low_s, histories_.dwell.high_s);
  if (condition == UseCondition::kHeld) words += fmt::format("; read up to {:.0f} s", inputs_.creep.to_s);
  if (condition == UseCondition::kOtherTemperature)
    words += fmt::format("; up to {:.1f} K from the calibration's", inputs_.temperature.half_width_of_runs_c());
  if (condition == UseCondition::kRemounted && inputs_.mounting) words += "; " + inputs_.mounting->from;
  return words;
}

const ConditionUncertainty& Uncertainty::condition(UseCondition which) const {
  return *std::ranges::find(conditions, which, &ConditionUncertainty::condition);
}

ReadingUncertainty reading_uncertainty(const ConditionUncertainty& condition, std::size_t taxel, double reading_psi,
                                       bool up) {
  const std::size_t levels = condition.pressure_psi.size();
  if (levels == 0) return {kNan, kNan};
  const std::size_t width = condition.expanded_psi.size() / levels;
  std::size_t below = levels, above = levels;
  for (std::size_t i = 0; i < levels; ++i) {
    if (condition.up[i] != up) continue;
    if (condition.pressure_psi[i] <= reading_psi) below = i;
    if (above == levels && condition.pressure_psi[i] >= reading_psi) above = i;
  }
  if (below == levels && above == levels) return {kNan, kNan};
  if (below == levels) below = above;
  if (above == levels) above = below;
  const double span = condition.pressure_psi[above] - condition.pressure_psi[below];
  const double share = span > 0.0 ? (reading_psi - condition.pressure_psi[below]) / span : 0.0;
  const auto between = [&](const std::vector<double>& values) {
    return std::lerp(values[below * width + taxel], values[above * width + taxel], share);
  };
  return {between(condition.error_psi), between(condition.expanded_psi)};
}

}  // namespace tactbench::analysis
