// The part of a budget that readings tell: of full sweeps, of inner branches, of other dwell times, of further runs.
#include <algorithm>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/budget_maker.h"

namespace tactbench::analysis {
namespace {

std::vector<double> errors_of(const LevelReadings& level, std::size_t taxel, std::size_t width) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < level.readings; ++i) errors.push_back(level.error_psi[i * width + taxel]);
  return errors;
}

// One-way analysis of variance (H.5.2) of readings in groups of unequal size.
struct GroupedScatter {
  double within = 0.0, within_dof = 0.0;    // variance, degrees of freedom
  double between = 0.0, between_dof = 0.0;  // of the groups' effect, what `within` explains taken off, not below 0
  double groups = 0.0, readings = 0.0;
};
GroupedScatter grouped_scatter(std::span<const double> errors, std::span<const int> group) {
  const int last = group.empty() ? -1 : *std::ranges::max_element(group);
  std::vector<std::vector<double>> groups(static_cast<std::size_t>(last + 1));
  for (std::size_t i = 0; i < errors.size(); ++i) groups[static_cast<std::size_t>(group[i])].push_back(errors[i]);
  std::erase_if(groups, [](const std::vector<double>& own) { return own.empty(); });
  GroupedScatter out;
  out.groups = static_cast<double>(groups.size());
  out.readings = static_cast<double>(errors.size());
  const double all = mean_of(errors);
  double squares_within = 0.0, squares_between = 0.0, n_squares = 0.0;
  for (const std::vector<double>& own : groups) {
    const double mean = mean_of(own), n = static_cast<double>(own.size());
    squares_within += squares_about(own, mean);
    squares_between += n * (mean - all) * (mean - all);
    n_squares += n * n;
  }
  out.within_dof = out.readings - out.groups;
  out.between_dof = out.groups - 1.0;
  if (out.within_dof > 0.0) out.within = squares_within / out.within_dof;
  if (!(out.between_dof > 0.0)) return out;
  const double size = (out.readings - n_squares / out.readings) / out.between_dof;
  out.between = std::max(0.0, (squares_between / out.between_dof - out.within) / size);
  return out;
}

double squared_u(const Budget& budget, UncertaintySource source) {
  for (const Contribution& row : budget.contributions)
    if (row.source == source) return row.u_psi * row.u_psi;
  return 0.0;
}

// Of the rows that this run's own full sweeps and frames tell of a reading.
double known_square(const Budget& budget) {
  double known = 0.0;
  for (const UncertaintySource source :
       {UncertaintySource::kNoise, UncertaintySource::kConverterStep, UncertaintySource::kZeroReturn,
        UncertaintySource::kRepeatability, UncertaintySource::kConditioning, UncertaintySource::kModel})
    known += squared_u(budget, source);
  return known;
}

// All sequences of the run are the calibration's: it goes the same ways again.
bool repeats_sequences(const Dataset& run, const Dataset& calibration) {
  return std::ranges::all_of(run.sequences, [&](const SequenceData& sequence) {
    return std::ranges::find(calibration.sequences, sequence.name, &SequenceData::name) != calibration.sequences.end();
  });
}

}  // namespace

double BudgetMaker::mean_error(std::size_t level, std::size_t taxel) const {
  return mean_by_shares(errors_of(errors_.levels[level], taxel, fit_.array().size()));
}

void BudgetMaker::find_histories(const Dataset& dataset, int threads) {
  const std::size_t width = fit_.array().size();
  for (std::size_t level = 0; level < errors_.levels.size(); ++level)
    for (std::size_t taxel = 0; taxel < width; ++taxel)
      histories_.corrections.push_back(mean_error(level, taxel));  // NaN without readings
  std::vector<std::string> fitted_names;
  for (const SequenceData& sequence : dataset.sequences) fitted_names.push_back(sequence.name);
  std::vector<const Dataset*> repeated, other;
  for (const Dataset* run : inputs_.history.same) (repeats_sequences(*run, dataset) ? repeated : other).push_back(run);
  const FrameErrors own = frame_errors(dataset, fit_, BranchesOf::kInnerBranches, threads);
  histories_.fitted = pooled_errors({&own, 1}, fit_, histories_.corrections);
  const auto keep = [&](UseCondition condition, const std::vector<const Dataset*>& runs, BranchesOf which,
                        std::span<const std::string> left_out = {}) {
    Evidence& evidence = histories_.made_in[static_cast<std::size_t>(condition)];
    for (const Dataset* run : runs) {
      FrameErrors errors = frame_errors(*run, fit_, which, threads, left_out);
      if (!errors.frames.empty()) evidence.runs.push_back(std::move(errors));
    }
    evidence.pooled = pooled_errors(evidence.runs, fit_, histories_.corrections);
  };
  keep(UseCondition::kFullSweeps, repeated, BranchesOf::kFullSweeps);
  keep(UseCondition::kFittedBranches, repeated, BranchesOf::kInnerBranches);
  keep(UseCondition::kAnyHistory, other, BranchesOf::kInnerBranches, fitted_names);
  std::vector<const Dataset*> held, dwelt;
  for (const Dataset* run : inputs_.history.dwelt) (median_dwell_s(*run) >= kHeldS ? held : dwelt).push_back(run);
  keep(UseCondition::kOtherDwell, dwelt, BranchesOf::kInnerBranches, fitted_names);
  keep(UseCondition::kHeld, held, BranchesOf::kInnerBranches, fitted_names);
  keep(UseCondition::kOtherTemperature, inputs_.history.warm, BranchesOf::kInnerBranches, fitted_names);
  keep(UseCondition::kRemounted, inputs_.history.mounted, BranchesOf::kInnerBranches, fitted_names);
  keep(UseCondition::kLater, inputs_.history.later, BranchesOf::kInnerBranches, fitted_names);
  histories_.dwell = dwell_effect_of(dataset, inputs_.history.paced, fit_, threads);
}

// What one run shows between its own sweeps is not all that another run differs by. Few sweeps of held-out runs tell
// little of one taxel, and much of all together: a ratio is pooled over the taxels (H.3.6).
void BudgetMaker::find_excess() {
  const HistoryErrors& repeated = made_in(UseCondition::kFullSweeps).pooled;
  if (!repeated.known()) return;
  const std::vector<std::size_t> fitted = fit_.fitted();
  std::vector<Excess> found(errors_.levels.size());
  for (std::size_t level = 0; level < found.size(); ++level) {
    const WindowErrors& window = repeated.windows[level];
    if (!(window.branches > 0.0) || errors_.levels[level].readings == 0) continue;
    std::vector<double> ratios, squares;
    for (const std::size_t taxel : fitted) {
      ratios.push_back(window.square_psi[taxel] / known_square(budget(taxel, level, UseCondition::kFullSweeps)));
      squares.push_back(window.square_psi[taxel]);
    }
    const auto taxels = static_cast<double>(fitted.size());
    const double common = std::min(1.0, window.common_square_psi / mean_of(squares));
    const double own = (1.0 - common) / std::max(1.0, taxels - 1.0);
    // The median: a few taxels with a flat curve would have the mean to themselves.
    found[level] = {std::max(0.0, median_of(std::move(ratios)) - 1.0),
                    window.branches / (common * common + (1.0 - common) * own), common};
  }
  excess_ = std::move(found);
}

double BudgetMaker::excess_psi2(const Budget& budget, std::size_t level) const {
  return excess_.empty() ? 0.0 : excess_[level].ratio * known_square(budget);
}

// The scatter of the array's mean against the taxels' own: of a reading's variance what all taxels have in common.
void BudgetMaker::find_common() {
  const std::size_t width = fit_.array().size();
  for (const LevelReadings& level : errors_.levels) {
    std::vector<double> means, variances;
    for (std::size_t i = 0; i < level.readings; ++i)
      means.push_back(mean_of(finite_of(std::span(level.error_psi).subspan(i * width, width))));
    for (std::size_t taxel = 0; taxel < width; ++taxel)
      variances.push_back(sample_variance(errors_of(level, taxel, width)));
    const double common = sample_variance(means), own = mean_of(finite_of(variances));
    common_scatter_.push_back(own > 0.0 && common > 0.0 ? std::min(1.0, common / own) : 0.0);
  }
}

// Repeatability is what the scatter within groups of sweeps has beyond the noise of one frame, which has a row of its
// own (4.3.10: nothing counts twice); conditioning, rest and first sweep are the scatter between the groups. The mean
// error is taken off: what is left of the lack of fit is how well that mean is known (4.2.3).
void BudgetMaker::add_readings(Budget& budget, std::size_t taxel, std::size_t level) const {
  const LevelReadings& readings = errors_.levels[level];
  const double noise = squared_u(budget, UncertaintySource::kNoise), common = common_scatter_[level];
  const GroupedScatter scatter = grouped_scatter(errors_of(readings, taxel, fit_.array().size()), readings.group);
  if (scatter.within_dof > 0.0)
    add(budget, UncertaintySource::kRepeatability, std::sqrt(std::max(0.0, scatter.within - noise)), 1.0, 1.0,
        scatter.within_dof, common);
  if (scatter.between_dof > 0.0)
    add(budget, UncertaintySource::kConditioning, std::sqrt(scatter.between), 1.0, 1.0, scatter.between_dof, common);
  const std::vector<VarianceShare> mean = {
      {std::sqrt(std::max(scatter.within, noise) / scatter.readings), std::max(1.0, scatter.within_dof)},
      {std::sqrt(scatter.between / std::max(1.0, scatter.groups)), std::max(1.0, scatter.between_dof)}};
  add(budget, UncertaintySource::kModel, combined_uncertainty(mean), 1.0, 1.0, effective_dof(mean), common);
}

const Evidence& BudgetMaker::made_in(UseCondition condition) const {
  return histories_.made_in[static_cast<std::size_t>(condition)];
}

// One run tells what it erred by, and not whether the next one does: two are needed, from which each checks the other.
bool BudgetMaker::told_by_runs(UseCondition condition) const {
  const Evidence& evidence = made_in(condition);
  return evidence.pooled.any_way() && evidence.runs.size() >= 2;
}

const HistoryErrors* BudgetMaker::history_of(UseCondition condition) const {
  const auto any = [](const HistoryErrors& history) { return history.any_way() ? &history : nullptr; };
  if (condition == UseCondition::kFullSweeps) return nullptr;
  if (condition == UseCondition::kFittedBranches) return any(histories_.fitted);
  if (condition != UseCondition::kStated && told_by_runs(condition)) return &made_in(condition).pooled;
  if (condition != UseCondition::kStated && condition != UseCondition::kRemounted) return nullptr;
  const HistoryErrors* history = any(made_in(UseCondition::kAnyHistory).pooled);
  return history == nullptr && condition == UseCondition::kStated ? any(histories_.fitted) : history;
}

// What the readings of the history err by beyond what the rows above say of them (4.3.10). A window without a way
// through it takes that of the nearest level of its direction.
void BudgetMaker::add_history(Budget& budget, std::size_t taxel, std::size_t level, UseCondition condition,
                              const HistoryErrors* history) const {
  const double excess = excess_psi2(budget, level);
  if (history == nullptr) {
    if (condition == UseCondition::kFullSweeps && !excess_.empty())
      add(budget, UncertaintySource::kHistory, std::sqrt(excess), 1.0, 1.0, excess_[level].dof, excess_[level].common);
    return;
  }
  const WindowErrors* own = nullptr;
  for (const WindowErrors& window : history->windows) {
    if (window.up != budget.up || !(window.branches > 0.0)) continue;
    const double off = std::abs(window.pressure_psi - budget.pressure_psi);
    if (own == nullptr || off < std::abs(own->pressure_psi - budget.pressure_psi)) own = &window;
  }
  if (own == nullptr) return;
  const double square = own->square_psi[taxel];
  const double common = square > 0.0 ? std::min(1.0, own->common_square_psi / square) : 0.0;
  // The fitted branches are gone again and again, so that each frame repeats one of these; another run adds to their
  // errors what it adds to those of sweeps.
  const bool fitted = condition == UseCondition::kFittedBranches;
  add(budget, UncertaintySource::kHistory,
      std::sqrt(std::max(0.0, square - known_square(budget)) + (fitted ? excess : 0.0)), 1.0, 1.0,
      fitted ? own->frames : own->branches, common);
}

void BudgetMaker::add_dwell(Budget& budget, std::size_t taxel, std::size_t level) const {
  if (!assessed(UncertaintySource::kDwell)) return;
  const double square = histories_.dwell.square_psi[level * fit_.array().size() + taxel];
  const double noise = 2.0 * squared_u(budget, UncertaintySource::kNoise);
  add(budget, UncertaintySource::kDwell, std::sqrt(std::max(0.0, square - noise)), std::sqrt(3.0), 1.0, kInfiniteDof,
      1.0);
}

void BudgetMaker::add_given(Budget& budget, std::size_t level, UseCondition condition) const {
  const auto add_it = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given, double common,
                          double counted_psi2 = 0.0) {
    if (!given) return;
    const double s = std::hypot(given->psi, given->share * budget.pressure_psi);
    add(budget, source, std::sqrt(std::max(0.0, s * s - counted_psi2)), 1.0, 1.0, given->dof, common);
  };
  add_it(UncertaintySource::kUniformity, inputs_.uniformity, 0.0);
  if (condition != UseCondition::kStated && (condition != UseCondition::kRemounted || told_by_runs(condition))) return;
  add_it(UncertaintySource::kMounting, inputs_.mounting, 1.0);
  // Mounts are runs, too: what held-out runs of one mount differ by is counted already (4.3.10).
  add_it(UncertaintySource::kMountingOwn, inputs_.mounting_own, 0.0,
         history_of(condition) == &made_in(UseCondition::kAnyHistory).pooled ? excess_psi2(budget, level) : 0.0);
}

}  // namespace tactbench::analysis
