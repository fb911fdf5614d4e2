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

constexpr const char* kNotRepeated =
    "no held-out run of the same sequences shows by how much another run differs: name one";
// What runs need, as a logarithm: how well their mean may be known at least. With normal errors 0.06 is 1.3 % of
// coverage.
constexpr double kMostOpen = 0.06;

// Where a held-out run has to be made ...
const char* under(UseCondition condition) {
  switch (condition) {
    case UseCondition::kOtherDwell:
      return " at another dwell";
    case UseCondition::kHeld:
      return " that holds the pressure";
    case UseCondition::kOtherTemperature:
      return " at another temperature";
    case UseCondition::kLater:
      return " of another day";
    default:
      return "";
  }
}

// ... and how.
std::string how(UseCondition condition) {
  if (condition == UseCondition::kHeld) return fmt::format(" with dwell_s of {:g} or more", kHeldS);
  if (condition == UseCondition::kOtherDwell)
    return fmt::format(" with a dwell_s more than three times as long, below {:g}", kHeldS);
  return {};
}

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
  if (condition == UseCondition::kFullSweeps && !assessed(UncertaintySource::kRepeatability))
    return missing(UncertaintySource::kRepeatability);
  if (condition == UseCondition::kFittedBranches && history_of(condition) == nullptr)
    return "the calibration has no inner branches";
  if (condition == UseCondition::kFullSweeps || condition == UseCondition::kFittedBranches)
    return made_in(condition).pooled.any_way() ? "" : kNotRepeated;
  const Evidence& evidence = made_in(condition);
  if (condition == UseCondition::kRemounted && !told_by_runs(condition)) {
    if (history_of(condition) == nullptr) return kNoHeldOut;
    if (!assessed(UncertaintySource::kMounting)) return missing(UncertaintySource::kMounting);
  } else if (!told_by_runs(condition)) {
    return evidence.runs.empty()
               ? fmt::format(
                     "no held-out run with reversals other than the fitted ones{}: name two "
                     "of random-reversal{}",
                     under(condition), how(condition))
               : fmt::format("run {} alone is a held-out one{}: a second one is needed, which checks U",
                             evidence.runs.front().run, under(condition));
  }
  // Runs of equal conditions need U as different as this: the mean of a few leaves open what the next ones need.
  const UseCondition told_by = scaled_by(condition);
  const auto runs = static_cast<double>(made_in(told_by).runs.size());
  const double scatter = scatter_of_runs(told_by), open = scatter / std::sqrt(runs);
  if (open <= kMostOpen || std::isnan(scatter)) return {};
  return fmt::format(
      "runs made alike differ too much, by a standard deviation of {:.0f} % in what U would have to be: {} "
      "leave U open by {:.1f} %; name {:.0f} or more",
      100.0 * scatter, counted(static_cast<std::size_t>(runs), "run"), 100.0 * open,
      std::ceil(std::pow(scatter / kMostOpen, 2)));
}

std::string BudgetMaker::basis(UseCondition condition) const {
  const HistoryErrors* history = history_of(condition);
  std::string words = history == nullptr ? "the full sweeps of this run" : history_words(*history);
  if (condition == UseCondition::kFittedBranches) words += ", of this run itself, which the models were fitted to";
  if (condition == UseCondition::kFullSweeps || condition == UseCondition::kFittedBranches)
    words += fmt::format("; {} held out of the same sequences", counted(made_in(condition).runs.size(), "run"));
  if (condition == UseCondition::kRemounted && !told_by_runs(condition)) words += "; " + inputs_.mounting->from;
  if (const double scale = scale_of(condition); scale != 1.0)
    words += fmt::format(
        "; U without the reference's part times {:.2f}, so that it covers 95.45 % of runs that it was "
        "not found from",
        scale);
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
