// How far U of a condition has to be widened or may be narrowed, so that it holds what it says of runs that it was not
// found from. Student's k supposes normal errors, as many degrees of freedom as ways, and taxels that err alike; a run
// that is held against U of the others supposes nothing of its errors (JCGM 100, G.1.2: k is that of the distribution).
#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/budget_maker.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kMostTaxels = 64;  // of an array, evenly taken: a quantile of thousands of frames needs no more

// A few runs tell little of how much they differ by, those of all conditions more, but conditions differ, too: all of
// them count as this many degrees of freedom beside the condition's own.
constexpr double kDofOfAll = 4.0;

// Of what runs made alike need, as a logarithm: squares about the means of the conditions.
struct Scatter {
  double squares = 0.0, dof = 0.0;
  void add(const Evidence& evidence) {
    if (evidence.needed.size() < 2) return;
    std::vector<double> logarithms;
    for (const double needed : evidence.needed) logarithms.push_back(std::log(needed));
    const auto runs = static_cast<double>(logarithms.size());
    // Each is held against the others, whose mean lies on the other side of that of all.
    squares += std::pow((runs - 1.0) / runs, 2) * squares_about(logarithms, mean_of(logarithms));
    dof += runs - 1.0;
  }
};

std::vector<std::size_t> some_of(const std::vector<std::size_t>& fitted) {
  std::vector<std::size_t> chosen;
  const std::size_t count = std::min(kMostTaxels, fitted.size());
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(fitted[i * fitted.size() / count]);
  return chosen;
}

// |error| over U of each frame of one taxel; `stated` has the levels of the budgets and that taxel alone.
void add_ratios(const FrameErrors& run, std::size_t taxel, std::size_t width, const ConditionUncertainty& stated,
                std::vector<double>& ratios) {
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const double error = run.error_psi[i * width + taxel];
    const double reading = run.frames[i].reference_psi + error;
    const auto [known, expanded] = reading_uncertainty(stated, 0, reading, run.frames[i].up);
    if (const double ratio = std::abs(error - known) / expanded; std::isfinite(ratio)) ratios.push_back(ratio);
  }
}

}  // namespace

UseCondition BudgetMaker::scaled_by(UseCondition condition) const {
  const bool own =
      condition == UseCondition::kFullSweeps || condition == UseCondition::kFittedBranches || told_by_runs(condition);
  return own ? condition : UseCondition::kAnyHistory;
}

double BudgetMaker::scale_of(UseCondition condition) const {
  return condition == UseCondition::kStated ? 1.0 : made_in(scaled_by(condition)).scale;
}

// U of each run is found from the others; where the calibration itself tells the most, from it and all of them.
void BudgetMaker::find_scale(UseCondition condition, int threads) {
  Evidence& evidence = histories_.made_in[static_cast<std::size_t>(condition)];
  const bool fitted = condition == UseCondition::kFullSweeps || condition == UseCondition::kFittedBranches;
  if (!evidence.pooled.any_way() || (!fitted && evidence.runs.size() < 2)) return;
  const std::size_t width = fit_.array().size();
  const std::vector<std::size_t> taxels = some_of(fit_.fitted());
  std::vector<std::size_t> levels;
  ConditionUncertainty empty;
  for (std::size_t level = 0; level < errors_.levels.size(); ++level) {
    if (errors_.levels[level].readings == 0) continue;
    levels.push_back(level);
    empty.pressure_psi.push_back(errors_.levels[level].pressure_psi);
    empty.up.push_back(errors_.levels[level].up);
  }
  std::vector<HistoryErrors> others;
  for (std::size_t run = 0; run < evidence.runs.size(); ++run)
    if (!fitted) others.push_back(pooled_errors(evidence.runs, fit_, histories_.corrections, run));
  std::vector<std::vector<std::vector<double>>> ratios(taxels.size());  // taxel, run, frame
  for_each_index(taxels.size(), threads, [&](std::size_t at) {
    std::vector<Budget> budgets;
    for (const std::size_t level : levels) budgets.push_back(without_history(taxels[at], level, condition));
    ratios[at].resize(evidence.runs.size());
    for (std::size_t run = 0; run < evidence.runs.size(); ++run) {
      ConditionUncertainty stated = empty;
      for (std::size_t i = 0; i < levels.size(); ++i) {
        Budget budget = budgets[i];
        add_history(budget, taxels[at], levels[i], condition, fitted ? history_of(condition) : &others[run]);
        std::erase_if(budget.contributions, [](const Contribution& row) { return is_of_reference(row.source); });
        finish(budget, 1.0);
        stated.expanded_psi.push_back(budget.expanded_psi);
        stated.error_psi.push_back(budget.error_psi);
      }
      add_ratios(evidence.runs[run], taxels[at], width, stated, ratios[at][run]);
    }
  });
  std::vector<double> all;
  for (std::size_t run = 0; run < evidence.runs.size(); ++run) {
    std::vector<double> own;
    for (const auto& of_taxel : ratios) own.insert(own.end(), of_taxel[run].begin(), of_taxel[run].end());
    all.insert(all.end(), own.begin(), own.end());
    if (!own.empty() && !fitted) evidence.needed.push_back(quantile_of(std::move(own), kCoverageProbability));
  }
  if (!all.empty()) evidence.scale = quantile_of(std::move(all), kCoverageProbability);
}

double BudgetMaker::scatter_of_runs(UseCondition condition) const {
  Scatter all;
  for (const Evidence& evidence : histories_.made_in) all.add(evidence);
  if (!(all.dof > 0.0)) return kNan;
  Scatter own{kDofOfAll * all.squares / all.dof, kDofOfAll};
  own.add(made_in(condition));
  return std::sqrt(own.squares / own.dof);
}

void BudgetMaker::find_scales(int threads) {
  for (std::size_t which = 1; which < kUseConditions; ++which) find_scale(static_cast<UseCondition>(which), threads);
}

}  // namespace tactbench::analysis
