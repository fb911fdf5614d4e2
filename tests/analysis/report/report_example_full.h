// The invented report input with everything that further runs add: U of a reading, as found, studies, objects; some
// names contain hostile characters.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "tests/analysis/report/report_example.h"

namespace tactbench::analysis::example {

inline const std::string kHostile = "</script><img src=x onerror=alert(1)> \" & \xE2\x80\xAE";

inline ContactFigures figures(double force) { return {force, 1.0, -2.0, -2.0 * force, -force, 98.0, 0.5}; }

inline ContactResult contact() {
  ContactResult out;
  out.run = 14;
  out.sequence = kHostile;
  out.positions = 1;
  out.repeats = 3;
  out.full_scale_v = example::kFullScaleV;
  out.full_scale_psi = example::kFullPsi;
  for (const bool rising : {true, false}) {
    for (const double target : {2.0, 6.0}) {
      if (!rising && target == 6.0) continue;
      ContactLevel level;
      level.target_n = target;
      level.rising = rising;
      level.frames = 3;
      level.force_n = target;
      level.raw = figures(2.0 * target);
      level.compensated = figures(1.1 * target);
      level.raw_place_error_mm = level.compensated_place_error_mm = std::numeric_limits<double>::quiet_NaN();
      level.raw_v.assign(256, 0.1 * target);
      level.compensated_psi.assign(256, target);
      level.compensated_psi[37] = std::numeric_limits<double>::quiet_NaN();
      out.levels.push_back(level);
    }
  }
  out.raw_distance = {0.1, std::numeric_limits<double>::quiet_NaN()};
  out.compensated_distance = {0.2, std::numeric_limits<double>::quiet_NaN()};
  return out;
}

inline ReportInput full_input() {
  ReportInput input = example::example_input();
  ReportResults& more = input.more;
  more.previous = AsFound{kHostile, input.evaluation, 254, input.judgement, kHostile};
  more.contacts = {contact()};
  Studies& studies = more.studies;
  studies.uniformity.not_assessed.clear();
  studies.uniformity.runs = {12, 15};
  studies.uniformity.angles_deg = {0, 90};
  studies.uniformity.pressure_psi = {20.0, 40.0};
  studies.uniformity.u_psi = {0.1, 0.2};
  studies.uniformity.residual_psi = {0.01, 0.02};
  studies.uniformity.chamber_share.assign(256, 0.005);
  studies.uniformity.chamber_psi.assign(256, 0.0);
  studies.uniformity.sensor_share.assign(256, -0.01);
  studies.uniformity.residual_rms_psi = 0.02;
  studies.uniformity.residual_other_sense_psi = 0.01;
  studies.remount.not_assessed.clear();
  studies.remount.runs = {12, 13};
  studies.remount.pressure_psi = {20.0, 40.0};
  studies.remount.within_psi = studies.remount.between_psi = studies.remount.mean_between_psi = {0.1, 0.2};
  studies.remount.taxel_between_psi.assign(256, 0.1);
  studies.remount.degrees = 1;
  studies.crosstalk.not_assessed.clear();
  studies.crosstalk.positions = 25;
  studies.crosstalk.row = {0.01, 0.001, 0.02, 600};
  studies.crosstalk.ghost_rows = {{3, 0.01}};
  studies.crosstalk.distance_pitches = {0.0, 1.0, 2.0, 3.0};
  studies.crosstalk.along_row_share = studies.crosstalk.along_column_share = {1.0, 0.5, 0.01, 0.01};
  studies.rate_hold.not_assessed.clear();
  ErrorSum error;
  error.add(0.25);
  studies.rate_hold.runs = {{16, kHostile, error, {{1.0, 2.0, error}, {2.0, 5.0, error}}, {}, 0.1, 0.05}};
  input.uncertainty.emplace();
  ConditionUncertainty kind;
  kind.name = kHostile;
  kind.median_psi = 0.4;
  for (const bool up : {true, false})
    for (const double psi : input.fit.pressure_psi) {
      if (!up && psi == kFullPsi) continue;
      LevelUncertainty& level = input.uncertainty->levels.emplace_back();
      level.pressure_psi = psi;
      level.up = up;
      for (int i = 0; i < 256; ++i) {
        const bool fitted = input.fit.taxels[static_cast<std::size_t>(i)].fitted();
        level.error_psi.push_back(fitted ? 0.002 * (i - 100) : std::numeric_limits<double>::quiet_NaN());
        level.expanded_psi.push_back(fitted ? 0.3 + 0.001 * i : std::numeric_limits<double>::quiet_NaN());
      }
      kind.pressure_psi.push_back(psi);
      kind.up.push_back(up);
      kind.error_psi.insert(kind.error_psi.end(), level.error_psi.begin(), level.error_psi.end());
      kind.expanded_psi.insert(kind.expanded_psi.end(), level.expanded_psi.begin(), level.expanded_psi.end());
    }
  input.uncertainty->conditions = {kind};
  input.applied = {{kHostile, false, 5, {0.0, 60.0, 120.0}, {0.0, 60.0, 0.0}}};
  return input;
}

}  // namespace tactbench::analysis::example
