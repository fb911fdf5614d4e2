// An invented report input for the report's tests: 16 x 16 taxels with spread, 31 levels, two sequences of loops, one
// dead and one saturated taxel. Shapes only resemble a sensor; nothing here is a measurement.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/report/report.h"
#include "tests/analysis/report/report_example_raw.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/analysis/support/sensor_models.h"

namespace tactbench::analysis::example {

// Over the fitted taxels, as the evaluation does.
inline double std_of(const std::vector<double>& values, const SensorModel& fit) {
  double sum = 0.0, squares = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (fit.taxels[i].status != TaxelStatus::kFitted) continue;
    sum += values[i];
    squares += values[i] * values[i];
    ++n;
  }
  return std::sqrt(std::max(0.0, (squares - sum * sum / n) / (n - 1)));
}

inline LevelFigures level_at(double pressure, const SensorModel& fit, const std::vector<double>& gain, Noise& noise) {
  LevelFigures level;
  level.pressure_psi = pressure;
  level.up_psi = pressure + 0.02;
  level.down_psi = pressure - 0.03;
  double mean_up = 0.0, mean_down = 0.0;
  int fitted = 0;
  for (std::size_t i = 0; i < gain.size(); ++i) {
    level.raw_up_v.push_back(gain[i] * loading(pressure));
    level.raw_down_v.push_back(std::min(5.0, gain[i] * unloading(pressure)));
    if (fit.taxels[i].status != TaxelStatus::kFitted) {
      level.comp_up_psi.push_back(std::numeric_limits<double>::quiet_NaN());
      level.comp_down_psi.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const double weak = pressure > 50.0 && pressure < kFullPsi ? 6.0 : 1.0;
    level.comp_up_psi.push_back(std::clamp(pressure + 0.4 * noise(), 0.0, kFullPsi));
    level.comp_down_psi.push_back(std::clamp(pressure + 0.5 * weak * noise(), 0.0, kFullPsi));
    const double raw = std::abs(level.raw_up_v[i] - level.raw_down_v[i]) / kFullScaleV;
    const double compensated = std::abs(level.comp_up_psi[i] - level.comp_down_psi[i]) / kFullPsi;
    level.raw_distance += raw;
    level.comp_distance += compensated;
    level.worst_taxel_distance = std::max(level.worst_taxel_distance, compensated);
    mean_up += level.comp_up_psi[i];
    mean_down += level.comp_down_psi[i];
    ++fitted;
  }
  level.raw_distance /= fitted;
  level.comp_distance /= fitted;
  level.raw_mean_distance = std::abs(unloading(pressure) - loading(pressure)) / kFullScaleV;
  level.comp_mean_distance = std::abs(mean_up - mean_down) / fitted / kFullPsi;
  level.raw_std_up = std_of(level.raw_up_v, fit) / kFullScaleV;
  level.raw_std_down = std_of(level.raw_down_v, fit) / kFullScaleV;
  level.comp_std_up = std_of(level.comp_up_psi, fit) / kFullPsi;
  level.comp_std_down = std_of(level.comp_down_psi, fit) / kFullPsi;
  level.flat_taxels = pressure > 50.0 ? static_cast<int>(8.0 * (pressure - 50.0)) : 0;
  level.comp_distance_observable = 0.8 * level.comp_distance;
  level.worst_taxel_distance_observable = 0.7 * level.worst_taxel_distance;
  level.made_worse = level.comp_distance > level.raw_distance;
  return level;
}

inline Trace trace_of(const std::string& name, const std::vector<double>& turns, Noise& noise) {
  Trace trace{name, {}, {}, {}, {}};
  for (std::size_t turn = 1; turn < turns.size(); ++turn) {
    const bool up = turns[turn] > turns[turn - 1];
    const double low = std::min(turns[turn], turns[turn - 1]), high = std::max(turns[turn], turns[turn - 1]);
    for (double x = turns[turn - 1]; up ? x < turns[turn] : x > turns[turn]; x += up ? 2.0 : -2.0) {
      const double inner = (high - low) / kFullPsi;
      const double gap = unloading(x) - loading(x);
      const double y = up ? loading(x) + (low / kFullPsi) * gap : unloading(x) - (1.0 - inner) * 0.5 * gap;
      trace.pressure_psi.push_back(x + 0.03 * noise());
      trace.model_v.push_back(y);
      trace.measured_v.push_back(y + 0.03 * noise());
      trace.compensated_psi.push_back(std::clamp(x + 0.6 * noise(), 0.0, kFullPsi));
    }
  }
  return trace;
}

inline SensorModel example_fit(std::vector<double>& gain, Noise& noise) {
  SensorModel fit;
  fit.model = "elam";
  fit.rows = fit.columns = 16;
  fit.run = 12;
  std::vector<double> up, down;
  for (int i = 0; i <= 30; ++i) fit.pressure_psi.push_back(2.0 * i);
  for (const double x : fit.pressure_psi) {
    up.push_back(loading(x));
    down.push_back(unloading(x));
  }
  const auto taxel = [&](double g) {
    std::vector<double> a, d;
    for (const double y : up) a.push_back(g * y);
    for (const double y : down) d.push_back(g * y);
    const ElamParameters parameters{0.79 + 0.03 * noise(), std::min(1.0, 0.99 + 0.01 * noise()),
                                    -0.0072 + 0.0004 * noise(), 0.6 + 0.03 * noise(), 0.34 + 0.04 * noise()};
    ModelTaxel out = by_hand::elam_taxel(PatternCurve(fit.pressure_psi, a, 0.0, g * kFullScaleV),
                                         PatternCurve(fit.pressure_psi, d, 0.0, g * kFullScaleV), parameters);
    out.fit.at_bound = parameters.beta_d >= 1.0 ? 2u : 0u;
    out.fit.j = 0.4 + 0.05 * noise();
    out.fit.mean_error = 0.025 + 0.003 * noise();
    out.fit.max_error = 0.12 + 0.01 * noise();
    out.noise = 0.0008;
    return out;
  };
  for (int i = 0; i < 256; ++i) {
    gain.push_back(std::max(0.4, 1.0 + 0.15 * noise()));
    fit.taxels.push_back(taxel(gain.back()));
  }
  by_hand::finish(fit, taxel(1.0));
  gain[37] = 0.0;
  fit.taxels[37] = by_hand::left_out(TaxelStatus::kDead);
  fit.taxels[200] = by_hand::left_out(TaxelStatus::kSaturated);
  fit.taxels[37].taxel = 37;
  fit.taxels[200].taxel = 200;
  return fit;
}

inline Evaluation example_evaluation(const SensorModel& fit, const std::vector<double>& gain, Noise& noise) {
  Evaluation e;
  e.run = e.model_run = 12;
  e.full_scale_v = kFullScaleV;
  e.full_scale_psi = kFullPsi;
  e.frames = 3310;
  for (const double pressure : fit.pressure_psi) e.levels.push_back(level_at(pressure, fit, gain, noise));
  const double n = static_cast<double>(e.levels.size());
  for (const LevelFigures& level : e.levels) {
    e.hysteresis_max_fs = std::max(e.hysteresis_max_fs, level.raw_mean_distance);
    e.raw_distance += level.raw_mean_distance / n;
    e.comp_distance += level.comp_distance / n;
    e.comp_distance_observable += level.comp_distance_observable / n;
    e.comp_distance_of_mean += level.comp_mean_distance / n;
  }
  e.hysteresis_mean_fs = e.raw_distance;
  e.worst_taxel_distance = 0.0313;
  e.worst_taxel_distance_observable = 0.0227;
  e.flat_share = 0.026;
  e.mean_error_psi = 0.5213;
  e.max_error_psi = 11.21;
  e.mean_error_observable_psi = 0.4021;
  e.max_error_observable_psi = 3.456;
  e.worst_taxel = 17;
  e.max_error_taxel = 20;
  e.max_error_at_psi = 56.0;
  e.worst_taxel_mean_error_psi = 1.2345;
  for (const ModelTaxel& taxel : fit.array()) {
    e.taxel_mean_error_psi.push_back(taxel.status == TaxelStatus::kFitted ? std::abs(0.5 + 0.12 * noise())
                                                                          : std::numeric_limits<double>::quiet_NaN());
  }
  e.traces.push_back(trace_of("descending", {0, 60, 10, 60, 20, 60, 30, 60, 40, 60, 50, 60, 0}, noise));
  e.traces.push_back(trace_of("ascending", {0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0}, noise));
  return e;
}

inline db::RunRecord example_run(std::int64_t number) {
  db::RunRecord run;
  run.run = number;
  run.uuid = "6f1d3c58-8b0e-4d57-9d6c-0c7a5f2b4e11";
  run.origin = "simulated";
  run.state = "ended";
  run.outcome = db::Outcome::kCompleted;
  run.safe_state = db::SafeState::kVerified;
  run.operator_name = "A. Operator";
  run.purpose = "characterization";
  run.sensor_serial = "TA16-0007";
  run.scanner_serial = "SC-0042";
  run.bench_id = "bench-1";
  run.bench_sha256 = std::string(64, 'b');
  run.sensor_sha256 = std::string(64, 'c');
  run.content_sha256 = std::string(64, 'd');
  run.overrides_json = "{\"seed\":5}";
  run.program_version = "0.1.0";
  run.git_commit = "0123456789ab";
  run.git_dirty = true;
  run.build_id = "Release, GNU 12.2.0";
  run.host = "lab-pc";
  run.seed = 5;
  run.sensor_seed = 7;
  run.started_utc = "2024-05-06T07:08:09Z";
  run.ended_utc = "2024-05-06T08:58:19Z";
  run.sequences = {{0, "descending", "", std::string(64, '1'), 5, 211},
                   {1, "ascending", "", std::string(64, '2'), 5, 451}};
  run.devices = {
      {"regulator", "VPPM-8L", "R-11", "1.2", "simulated", R"({"span_bar":[0,9],"certificate":"not calibrated"})"},
      {"pressure reference", "PT-150", "P-22", "", "simulated", R"({"span_psi":[0,150],"certificate":"C-2024-17"})"},
      {"tactile scanner", "TS-256", "SC-0042", "0.9.3", "simulated", R"({"volts_per_count":7.6295e-05})"}};
  return run;
}

inline ReportInput example_input() {
  Noise noise;
  std::vector<double> gain;
  ReportInput input;
  input.run = example_run(12);
  input.sensor = db::SensorRecord{"TA16-0007",         "array-16x16",         "", std::string(64, 'c'), "SC-0042",
                                  "second of its lot", "2024-05-01T00:00:00Z"};
  input.fit = example_fit(gain, noise);
  input.evaluation = example_evaluation(input.fit, gain, noise);
  input.health = example_health(input.fit, gain);
  input.behaviour = example_behaviour(input.fit, gain, noise);
  input.history = example_history();
  input.laboratory = example_laboratory();
  input.frame_count = 3310;
  input.program_version = "0.1.0, commit 0123456789ab";
  for (const char* title : {"held-out run", "re-mounted", "one month later at +5 °C"}) {
    const auto number = static_cast<std::int64_t>(13 + input.held_out.size());
    HeldOut held_out{title, example_run(number), input.evaluation};
    held_out.evaluation.run = number;
    held_out.evaluation.frames = 662;
    held_out.evaluation.comp_distance *= 1.0 + 0.1 * static_cast<double>(number - 12);
    input.held_out.push_back(std::move(held_out));
  }
  const auto judged = [](Criterion criterion, double value, double limit, const Scope& scope = {}) {
    return by_hand::judged_figure(12, criterion, value, limit, value <= limit ? Verdict::kPass : Verdict::kFail, scope,
                                  12);
  };
  input.judgement =
      by_hand::judgement_of({judged(Criterion::kMeanError, input.evaluation.mean_error_psi, 1.0),
                             judged(Criterion::kWorstTaxelError, input.evaluation.worst_taxel_mean_error_psi, 2.0),
                             judged(Criterion::kDistanceOfMean, input.evaluation.comp_distance_of_mean, 0.015),
                             judged(Criterion::kUnfitTaxels, 2, 1),
                             judged(Criterion::kMismatch, 0.021, 0.06, Scope::level(40.0, Direction::kUp))});
  return input;
}

}  // namespace tactbench::analysis::example
