// The made-up report input with everything that further runs add: models compared, as found, studies, objects; some of
// it under a hostile name.
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
  more.usable = usable_range(input.fit);
  more.straight = {14.25, 51.5, 30.125};
  for (const NamedTaxel& taxel : named_taxels({1, 2, 3}, 16)) {
    ComparedTaxel compared{taxel, 3.5, {}};
    for (const Trace& trace : input.evaluation.traces) {
      more.traces.push_back(
          {taxel, kHostile, trace.pressure_psi, trace.measured_v, trace.model_v, trace.compensated_psi});
      ComparedSequence sequence{kHostile, trace.pressure_psi, trace.measured_v, {}};
      for (const char* model : kComparedModels) {
        ComparedModel own;
        own.model = model;
        own.model_v = trace.model_v;
        own.j_v2 = 0.5;
        own.mean_error_v = 0.02;
        own.max_error_v = 0.1;
        own.operations_per_sample = 9;
        own.parameters = {{"alpha", 1e-9, "1", 0.0, 1.0}, {"beta", 0.5, "1", 0.0, 1.0}};
        sequence.models.push_back(own);
      }
      sequence.models[1] = {};
      sequence.models[1].model = "mpi";
      sequence.models[1].failed = "no such luck";
      compared.sequences.push_back(sequence);
    }
    more.models.taxels.push_back(compared);
  }
  more.previous = AsFound{kHostile, input.evaluation, 254, {}, kHostile};
  more.previous->evaluation.levels[10].comp_distance = 0.0;  // as left is worse there than as found
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
  return input;
}

}  // namespace tactbench::analysis::example
