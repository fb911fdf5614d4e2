// The part of the made-up report input that needs no model: shapes of loops, health, raw behaviour, history,
// laboratory.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/report/report.h"

namespace tactbench::analysis::example {

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

}  // namespace tactbench::analysis::example
