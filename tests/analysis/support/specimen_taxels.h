// Taxels of the simulated sensor on the paper's two sequences, without rig and store: test data for identification and
// compensation that none of the models generated.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/elam.h"
#include "bench/simulation/specimen.h"
#include "tests/analysis/support/fit_samples.h"

namespace synthetic {

// Steps of 2 psi in about 0.4 s, 2 s of dwell, then a frame, as the bench does.
class SpecimenWalk {
 public:
  explicit SpecimenWalk(unsigned sensor_seed)
      : specimen_([&] {
          tactbench::bench::SpecimenOptions options;
          options.sensor_seed = sensor_seed;
          return options;
        }()) {
    for (int n = 0; n < 3; ++n)
      for (const double level : levels_of({0, 60, 0})) go(level);
  }
  // A row of outputs, one per taxel, at the end of the dwell; a step may be of any size.
  const std::vector<double>& go(double level, double ramp_s = 0.4, double dwell_s = 2.0) {
    for (int k = 1; k <= 4; ++k) specimen_.advance(level_ + (level - level_) * k / 4.0, ramp_s / 4.0);
    for (int k = 0; k < 4; ++k) specimen_.advance(level, dwell_s / 4.0);
    level_ = level;
    volts_.resize(256);
    specimen_.output(volts_);
    return volts_;
  }

 private:
  tactbench::bench::Specimen specimen_;
  double level_ = 0.0;
  std::vector<double> volts_;
};

// Every `stride`-th taxel: both sequences, with white noise of noise_v, patterns from the mean of the full sweeps.
inline std::vector<FitData> specimen_taxels(unsigned sensor_seed, std::size_t count, double noise_v) {
  SpecimenWalk walk(sensor_seed);
  std::mt19937 random(sensor_seed);
  std::normal_distribution<double> normal;
  const std::size_t stride = 256 / count;
  std::vector<std::vector<History>> histories(count);
  for (const std::vector<double>& turns : {kDescendingTurns, kAscendingTurns}) {
    const std::vector<double> levels = levels_of(turns);
    for (auto& own : histories) own.push_back({"made", levels, {}, branches_along(levels), {}, {}});
    for (const double level : levels) {
      const std::vector<double>& volts = walk.go(level);
      for (std::size_t t = 0; t < count; ++t)
        histories[t].back().y.push_back(volts[t * stride] + noise_v * normal(random));
    }
  }
  std::vector<FitData> taxels;
  for (auto& own : histories) {
    std::vector<TaxelTable> tables;
    for (const History& history : own) tables.push_back({history.x, history.y, history.branches});
    const ExternalLoop loop = external_loop(tables, 1);
    const double low = 0.5 * (loop.ascending.front() + loop.descending.front());
    const double high = 0.5 * (loop.ascending.back() + loop.descending.back());
    taxels.push_back({std::move(own), PatternCurve(loop.pressure_psi, loop.ascending, low, high),
                      PatternCurve(loop.pressure_psi, loop.descending, low, high)});
  }
  return taxels;
}

}  // namespace synthetic

namespace tactbench::analysis::by_hand {

// Makes sensor models from given taxels.

// A fitted taxel of ELAM whose external loop is the two patterns.
inline ModelTaxel elam_taxel(const PatternCurve& ascending, const PatternCurve& descending,
                             const ElamParameters& parameters = {}) {
  ModelTaxel taxel;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::make_shared<ElamHysteresis>(ElamModel{ascending, descending, parameters, {}});
  taxel.ascending = ascending;
  taxel.descending = descending;
  taxel.loop_low = taxel.y0();
  taxel.fit.full_scale = taxel.yu() - taxel.y0();
  return taxel;
}

inline ModelTaxel left_out(TaxelStatus status) {
  ModelTaxel taxel;
  taxel.status = status;
  return taxel;
}

// Numbers the taxels and puts the mean behind them, in the place of one that is there.
inline void finish(SensorModel& fit, ModelTaxel mean) {
  if (!fit.taxels.empty() && fit.taxels.back().taxel == kMeanTaxel) fit.taxels.pop_back();
  for (std::size_t i = 0; i < fit.taxels.size(); ++i) fit.taxels[i].taxel = static_cast<int>(i);
  mean.taxel = kMeanTaxel;
  fit.taxels.push_back(std::move(mean));
}

}  // namespace tactbench::analysis::by_hand
