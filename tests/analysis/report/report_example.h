// An invented report input for the report's tests: 16 x 16 taxels with spread, 31 levels, two sequences of loops, one
// dead and one saturated taxel. Shapes only resemble a sensor; nothing here is a measurement.
#pragma once

#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/report/report.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/analysis/support/specimen_taxels.h"

namespace tactbench::analysis::example {

// The part of the made-up report input that needs no model: shapes of loops, health, raw behaviour, history,
// laboratory.

inline constexpr double kFullScaleV = 3.49;
inline constexpr double kFullPsi = 60.0;

inline double loading(double x) { return kFullScaleV * std::pow(x / kFullPsi, 1.15); }
inline double unloading(double x) { return kFullScaleV * (1.0 - std::pow(1.0 - x / kFullPsi, 1.8)); }

// About normal, the same on every library: std::normal_distribution is not.
class Noise {
 public:
  double operator()() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(engine_() >> 11) * 0x1.0p-53;
    return sum;
  }

 private:
  std::mt19937_64 engine_{7};
};

inline Behaviour example_behaviour(const SensorModel& fit, const std::vector<double>& gain, Noise& noise) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Behaviour b;
  b.pressure_psi = fit.pressure_psi;
  b.full_scale_v = kFullScaleV;
  b.equilibration_psi = 40.0;
  b.repeats = 5;
  for (std::size_t i = 0; i < gain.size(); ++i) {
    const bool counts = fit.taxels[i].status == TaxelStatus::kFitted;
    if (counts) b.taxels.push_back(static_cast<int>(i));
    b.gain.push_back(counts ? gain[i] : nan);
    b.hysteresis_max.push_back(counts ? 0.25 + 0.01 * noise() : nan);
    b.hysteresis_mean.push_back(counts ? 0.10 + 0.005 * noise() : nan);
  }
  for (const auto& [name, taxel, factor] : {std::tuple{"mean", -1, 1.0}, std::tuple{"best", 3, 1.1},
                                            std::tuple{"median", 100, 0.95}, std::tuple{"worst", 17, 0.8}}) {
    RawLoop loop{name, taxel, factor * kFullScaleV, 0.25 / factor, 0.10 / factor, {}, {}};
    for (const double x : b.pressure_psi) {
      loop.up_v.push_back(factor * loading(x));
      loop.down_v.push_back(factor * unloading(x));
    }
    b.loops.push_back(loop);
  }
  for (const double x : b.pressure_psi) b.repeatability.push_back({x, 0.001, 0.0012, 0.003 + 1e-5 * x, 0.0034});
  b.zero_returns = {{"descending", 5, 0.012, 0.02, 0.05, 17}, {"ascending", 5, -0.004, -0.007, -0.02, 18}};
  b.creep = {{20, "creep-hold", 40.0, 2.0, 602.0, 2.10, 2.14, 0.0083, 0.0002, 301}};
  return b;
}

inline Health example_health(const SensorModel& fit, const std::vector<double>& gain) {
  Health health;
  health.rows = health.columns = 16;
  for (std::size_t i = 0; i < gain.size(); ++i) {
    health.low_v.push_back(0.001);
    health.high_v.push_back(0.002 + gain[i] * kFullScaleV);
    health.noise_v.push_back(i == 50 ? 0.01 : 0.0008);
    if (fit.taxels[i].status != TaxelStatus::kFitted)
      health.findings.push_back({static_cast<int>(i), to_string(fit.taxels[i].status), "made up", true});
    if (i == 50) health.findings.push_back({50, "noisy", "made up, too", false});
  }
  health.median_noise_v = 0.0008;
  health.swaps_assessed = true;
  health.swaps = {{true, 3, 4, 0.2, 0.97}};
  return health;
}

inline RunLog example_history() {
  RunLog history;
  history.loaded = true;
  history.frames = 3310;
  history.flagged = 3;
  history.void_frames = 12;
  history.flags = {{"dwell", 2}, {"retried", 1}};
  history.events = {{101.0, "attempt", "frame, 1 of 3: the scanner did not answer"},
                    {200.0, "pause", "running -> paused: asked by a person"},
                    {300.0, "warning", "the seating is not what it was"}};
  history.voids = {{"descending", 1, 3, 0, "TB-BRANCH-BROKEN: went back by 0.31 psi"}};
  history.surroundings = {{"temperature_c", 22.9, 23.2, 4}};
  history.checks = {{12, 0, "seating", "warning", R"({"findings":[{"text":"row 3 answers weakly"}]})", {}}};
  history.time_spent = "settling 40 %, dwelling 50 %";
  history.seating_v = history.earlier_seating_v = std::vector<double>(256, 0.5);
  return history;
}

inline Laboratory example_laboratory() {
  Laboratory lab;
  lab.laboratory = "Tactile Laboratory";
  lab.customer = "Robots & Co";
  lab.instruments = {{"P-22", "D-K 17, C-2024-18", "a laboratory", "2023-05-01", "2024-05-01", "two years old"}};
  lab.sha256 = std::string(64, 'f');
  return lab;
}

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

// The invented report input with everything that further runs add: U of a reading, as found, studies, objects; some
// names contain hostile characters.

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

namespace tactbench::analysis {

// Parses a report's page for tests: tags, attributes, xmllint; and its data.

inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline nlohmann::json report_json(const ReportInput& input) { return nlohmann::json::parse(render_report(input).json); }

// 0 when xmllint finds the page well-formed; -1 when there is no xmllint.
inline int xmllint(const std::string& page) {
  if (std::system("command -v xmllint >/dev/null 2>&1") != 0) return -1;
  const auto path =
      std::filesystem::temp_directory_path() / ("tactbench-report-" + std::to_string(::getpid()) + ".html");
  std::ofstream(path, std::ios::binary) << page;
  const int status = std::system(("xmllint --noout --nonet '" + path.string() + "'").c_str());
  std::filesystem::remove(path);
  return status;
}

inline void require_well_formed(const std::string& page) {
  const int status = xmllint(page);
  if (status < 0) {
    WARN("xmllint (package libxml2-utils) is not installed: well-formedness not checked");
    return;
  }
  CHECK(status == 0);
}

// The tags as a parser sees them: text holds no raw '<', the JSON none at all.
inline std::vector<std::string> tags_of(const std::string& page) {
  std::vector<std::string> out;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    out.push_back(page.substr(at + 1, page.find('>', at) - at - 1));
  }
  return out;
}

// name="value" pairs of a tag; the page writes double quotes only.
inline std::vector<std::pair<std::string, std::string>> attributes_of(const std::string& tag) {
  std::vector<std::pair<std::string, std::string>> out;
  std::size_t at = tag.find(' ');
  while (at != std::string::npos) {
    const std::size_t equals = tag.find("=\"", at);
    if (equals == std::string::npos) break;
    const std::size_t end = tag.find('"', equals + 2);
    if (end == std::string::npos) break;
    out.emplace_back(tag.substr(at + 1, equals - at - 1), tag.substr(equals + 2, end - equals - 2));
    at = tag.find(' ', end);
  }
  return out;
}

inline std::set<std::string> words_of(const std::string& words) {
  std::istringstream stream(words);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Every figure and table has its title.
inline void require_titled(const std::string& page) {
  CHECK(count(page, "<svg ") == count(page, "<svg role=\"img\""));
  CHECK(count(page, "<svg ") == count(page, "</title>") - 1);
  CHECK(count(page, "<table") == count(page, "<caption>"));
}

// Nothing that loads or runs: only elements and attributes that the report is known to need.
inline void require_inert(const std::string& page) {
  CHECK(count(page, "<script") == 1);
  CHECK(count(page, "<script type=\"application/json\" id=\"report-data\">") == 1);
  CHECK(count(page, "</script") == 1);
  static const std::set<std::string> elements = words_of(
      "!DOCTYPE aside html head meta title style body header main footer nav ul li a h1 h2 h3 h4 p div span code br "
      "table tr thead tbody th td b figcaption figure svg g path text script caption");
  static const std::set<std::string> attributes = words_of(
      "lang charset http-equiv content name id class role scope colspan rowspan href aria-label tabindex viewBox width "
      "height fill stroke stroke-width stroke-linecap stroke-dasharray d transform x y text-anchor type style");
  for (const std::string& tag : tags_of(page)) {
    const std::size_t start = tag.front() == '/' ? 1 : 0;
    const std::string name = tag.substr(start, tag.find_first_of(" /", start) - start);
    if (!elements.contains(name)) FAIL_CHECK("element " << tag.substr(0, 100));
    for (const auto& [attribute, value] : attributes_of(tag)) {
      if (!attributes.contains(attribute)) FAIL_CHECK("attribute " << attribute << " in " << tag.substr(0, 100));
      if (attribute == "href" && value.front() != '#') FAIL_CHECK("link to " << value);
      if (value.find("url(") != std::string::npos) FAIL_CHECK("url in " << attribute);
    }
  }
  const std::string style = page.substr(page.find("<style>"), page.find("</style>") - page.find("<style>"));
  CHECK_FALSE(contains(style, "url("));
  CHECK_FALSE(contains(style, "@import"));
  CHECK(contains(page,
                 "http-equiv=\"Content-Security-Policy\" content=\"default-src &#39;none&#39;; "
                 "style-src &#39;unsafe-inline&#39;; img-src data:\""));
}

}  // namespace tactbench::analysis
