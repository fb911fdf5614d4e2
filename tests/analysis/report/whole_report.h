// A report's input with every part filled: uncertainty at each level, conditions of use, verdicts with U.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/analysis/report/report_example_full.h"

namespace tactbench::analysis::pages_in_numbers {

inline Budget budget_drawn(example::Noise& noise, int taxel, double pressure, bool up) {
  Budget budget;
  budget.taxel = taxel;
  budget.pressure_psi = pressure;
  budget.up = up;
  budget.error_psi = 0.3 * noise();
  budget.readings = 12;
  for (std::size_t source = 0; source < kUncertaintySources; ++source) {
    if (source == 7 || source == 14) continue;
    const double u = 0.02 + 0.1 * std::abs(noise());
    budget.contributions.push_back({static_cast<UncertaintySource>(source), u * 1.7, 1.7, 1.0 + 0.1 * noise(), u,
                                    source % 3 == 0 ? 9.0 + 2.0 * noise() : kInfiniteDof, 0.5});
    budget.combined_psi = std::hypot(budget.combined_psi, u);
  }
  budget.dof = 41.3;
  budget.factor = 2.07;
  budget.expanded_psi = budget.factor * budget.combined_psi;
  budget.linear = pressure < 50.0;
  return budget;
}

inline Uncertainty uncertainty_drawn(const SensorModel& fit, example::Noise& noise) {
  Uncertainty u;
  for (const bool up : {true, false})
    for (double pressure = 0.0; pressure <= (up ? 60.0 : 55.0); pressure += 5.0) {
      LevelUncertainty level;
      level.pressure_psi = pressure;
      level.up = up;
      level.median = budget_drawn(noise, 40, pressure, up);
      level.worst = budget_drawn(noise, 17, pressure, up);
      level.worst.expanded_psi = 2.5 * level.median.expanded_psi;
      for (std::size_t taxel = 0; taxel < fit.array().size(); ++taxel) {
        const bool fitted = fit.taxels[taxel].fitted();
        level.expanded_psi.push_back(fitted ? 0.4 + 0.01 * pressure + 0.05 * noise() : std::nan(""));
        level.error_psi.push_back(fitted ? 0.2 * noise() : std::nan(""));
        level.factor.push_back(fitted ? 2.0 + 0.01 * std::abs(noise()) : std::nan(""));
      }
      level.array = {0.11 + 0.001 * pressure, 0.23 + 0.002 * pressure, pressure > 0.0 ? 0.012 : std::nan("")};
      level.not_linear = pressure > 50.0 ? 7 : 0;
      u.levels.push_back(level);
    }
  u.chosen = 17;
  u.missing[7] = "no runs of one sensor turned above 40 psi";
  u.missing[14] = "the run has no temperature readings";
  u.from[15] = "runs 3 to 6 at 40 psi";
  u.reference.reading_psi = {0.0, 30.0, 60.0};
  u.reference.expanded_psi = {0.04, 0.05, 0.09};
  u.reference.drift_stated_psi = u.reference.drift_psi = 0.06;
  u.reference.resolution_psi = 0.003125;
  u.creep.not_assessed.clear();
  u.creep.read_after_s = 2.25;
  u.creep.to_s = 601.5;
  u.creep.levels = {{"creep-hold", 40.0, true, 2.5, 601.5, std::vector<double>(fit.array().size(), 0.0125), 0.0125},
                    {"creep-hold", 20.0, false, 2.5, 640.0, std::vector<double>(fit.array().size(), 0.0225), 0.0225}};
  u.dwell.not_assessed.clear();
  u.dwell.run = 31;
  u.dwell.low_s = 1.5;
  u.dwell.high_s = 24.5;
  u.dwell.base_s = 2.25;
  for (std::size_t which = 1; which < kUseConditions; ++which) {
    ConditionUncertainty condition;
    condition.condition = static_cast<UseCondition>(which);
    if (which == 3 || which == 6) {
      condition.not_valid = "no held-out run at 40 psi";
    } else {
      condition.basis = "2 runs, frames 1.0 to 2.5 s after the command";
      condition.scale = which == 1 ? 1.0 : 1.125;
      condition.median_psi = 0.4 + 0.1 * static_cast<double>(which);
      for (const LevelUncertainty& level : u.levels) {
        condition.pressure_psi.push_back(level.pressure_psi);
        condition.up.push_back(level.up);
        condition.expanded_psi.insert(condition.expanded_psi.end(), level.expanded_psi.begin(),
                                      level.expanded_psi.end());
        condition.error_psi.insert(condition.error_psi.end(), level.error_psi.begin(), level.error_psi.end());
      }
    }
    u.conditions.push_back(condition);
  }
  return u;
}

inline ReportInput whole_report(PressureUnit unit) {
  ReportInput input = example::full_input();
  example::Noise noise;
  input.unit = unit;
  input.uncertainty = uncertainty_drawn(input.fit, noise);
  for (const db::VerdictRecord& verdict : input.verdicts)
    input.judged.push_back({verdict.criterion, verdict.scope, verdict.unit, 0.1 * verdict.value, 0.05 * verdict.value,
                            9.4, 2.3, "scatter of 5 repeats at 40 psi", "", verdict.run});
  input.judged[1].expanded = std::nan("");
  input.judged[1].missing = "one repeat at 40 psi";
  input.judged[3].expanded = 0.0;
  input.method = {"descending: to 60 psi in steps of 2 psi, 2 s each", "ascending: to 60 psi at 2.5 psi/s"};
  input.further = {example::example_run(20), example::example_run(21)};
  input.approvals = {{}};
  return input;
}

}  // namespace tactbench::analysis::pages_in_numbers
