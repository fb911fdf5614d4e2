// The part of a budget that readings tell: of full sweeps, of inner branches, of other dwell times, of further runs.
#include <algorithm>
#include <cmath>
#include <iterator>

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

}  // namespace

void BudgetMaker::find_histories(const Dataset& dataset, int threads) {
  corrections_ = mean_errors(errors_, fit_.array().size());
  counted_ = counted_errors(dataset, inputs_.history, fit_, threads);
  std::vector<FrameHistory> reversals = counted_.in(UseCondition::kReversals).histories;
  std::ranges::copy(counted_.in(UseCondition::kSmallReversals).histories, std::back_inserter(reversals));
  reversals_ = pooled_errors(reversals, fit_, corrections_);
  if (!any_way(reversals_)) {
    const FrameErrors own = frame_errors(dataset, fit_, threads);
    FrameHistory inner{&own, {}};
    for (std::size_t i = 0; i < own.frames.size(); ++i)
      if (!own.frames[i].full) inner.frames.push_back(i);
    reversals_ = pooled_errors({&inner, 1}, fit_, corrections_);
  }
  dwell_ = dwell_effect_of(dataset, inputs_.history.paced, fit_, threads);
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

// What the readings of the history err by beyond what the rows above say of them (4.3.10). A window without a way
// through it takes that of the nearest level of its direction.
void BudgetMaker::add_history(Budget& budget, std::size_t taxel) const {
  const WindowErrors* own = nullptr;
  for (const WindowErrors& window : reversals_) {
    if (window.up != budget.up || !(window.branches > 0.0)) continue;
    const double off = std::abs(window.pressure_psi - budget.pressure_psi);
    if (own == nullptr || off < std::abs(own->pressure_psi - budget.pressure_psi)) own = &window;
  }
  if (own == nullptr) return;
  const double square = own->square_psi[taxel];
  const double common = square > 0.0 ? std::min(1.0, own->common_square_psi / square) : 0.0;
  add(budget, UncertaintySource::kHistory, std::sqrt(std::max(0.0, square - known_square(budget))), 1.0, 1.0,
      own->branches, common);
}

void BudgetMaker::add_dwell(Budget& budget, std::size_t taxel, std::size_t level) const {
  if (!assessed(UncertaintySource::kDwell)) return;
  const double square = dwell_.square_psi[level * fit_.array().size() + taxel];
  const double noise = 2.0 * squared_u(budget, UncertaintySource::kNoise);
  add(budget, UncertaintySource::kDwell, std::sqrt(std::max(0.0, square - noise)), std::sqrt(3.0), 1.0, kInfiniteDof,
      1.0);
}

void BudgetMaker::add_given(Budget& budget) const {
  const auto add_it = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given, double common) {
    if (given) add(budget, source, given->u(budget.pressure_psi), 1.0, 1.0, given->dof, common);
  };
  add_it(UncertaintySource::kUniformity, inputs_.uniformity, 0.0);
  add_it(UncertaintySource::kMounting, inputs_.mounting, 1.0);
  add_it(UncertaintySource::kMountingOwn, inputs_.mounting_own, 0.0);
}

double BudgetMaker::hidden_psi(double pressure_psi) const {
  if (!reference_.certificate_missing.empty() || !reference_.holds_at(pressure_psi)) return kNan;
  return std::hypot(reference_.combined_u(pressure_psi),
                    inputs_.uniformity ? inputs_.uniformity->u(pressure_psi) : 0.0);
}

}  // namespace tactbench::analysis
