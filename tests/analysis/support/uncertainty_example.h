// A small synthetic array, and a run's record whose reference has a certificate.
#pragma once

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/synthetic.h"

namespace uncertainty_example {

using namespace tactbench;
using namespace tactbench::analysis;

// A run's record with a reference that has a certificate.
inline db::RunRecord record_with_reference(const std::string& reference, const std::string& due = "2027-01-31") {
  db::RunRecord run;
  run.origin = "simulated";
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {
      {"analog module", "M", "1", "", "simulated",
       R"({"input_volts":{"raw_low":0,"raw_high":32000,"low":0,"high":10}})"},
      {"pressure reference", "P", "2", "", "simulated",
       R"({"volts_low":0,"volts_high":10,"psi_low":0,"psi_high":100,"independent":true,"certificate":"C-1","due":")" +
           due + "\"" + reference + "}"},
      {"tactile scanner", "T", "3", "", "simulated", R"({"volts_per_count":7.62951094834821e-05})"}};
  return run;
}

inline constexpr const char* kWithCertificate =
    R"(,"drift_psi":0.05,"correction":{"reading_psi":[0,60],"correction_psi":[0,0],)"
    R"("expanded_uncertainty_psi":[0.04,0.16],"coverage_factor":2})";

struct Example {
  Dataset dataset;
  SensorModel fit;
  explicit Example(double noise_v = 0.0015, int columns = 3) {
    const synthetic::Array array({.rows = 1, .columns = columns, .sensor_seed = 4});
    dataset = synthetic::run(array, {.seed = 9, .noise_v = noise_v, .repeats = 3});
    dataset.scans = 2;
    fit = fit_array(dataset);
  }
};

inline const Contribution* row_of(const Budget& budget, UncertaintySource source) {
  const auto found = std::ranges::find(budget.contributions, source, &Contribution::source);
  return found == budget.contributions.end() ? nullptr : &*found;
}

// One that has to be there.
inline const Contribution& known_row(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  REQUIRE(row != nullptr);
  return *row;
}

}  // namespace uncertainty_example

namespace effect_runs {

// Runs that creep, and runs at other temperatures, of the sensor of uncertainty_example: by formula, so that the
// expected results can be computed by hand.

using namespace uncertainty_example;

inline double output_up(const Example& example, std::size_t taxel, double pressure) {
  const ElamModel& model = *elam_of(example.fit.taxels[taxel]);
  return ElamCurve(model, true, model.x0(), model.y0()).output(pressure);
}
inline double zero_of(const Example& example, std::size_t taxel) { return example.fit.taxels[taxel].y0(); }

// The same output for every taxel: its curve's at the level, and `per_decade` more of that over the zero for each
// decade of time since 1 s. Frames from `from_s` on, `step_s` apart, after one at 0 psi.
struct HoldOptions {
  double level_psi = 40.0, from_s = 2.0, step_s = 2.0, per_decade = 0.01, reference_drift_psi = 0.0;
  int frames = 100;
};
inline Dataset hold_run(const Example& example, const HoldOptions& options) {
  Dataset run = example.dataset;
  const std::size_t width = example.fit.array().size();
  Repeat repeat;
  repeat.steps.push_back({0.0, 0.0, 1.0, 1.0});
  for (std::size_t taxel = 0; taxel < width; ++taxel) repeat.volts.push_back(zero_of(example, taxel));
  for (int i = 0; i < options.frames; ++i) {
    const double held = options.from_s + options.step_s * i;
    const double drift = i == 0 ? 0.0 : options.reference_drift_psi;
    repeat.steps.push_back({options.level_psi, options.level_psi + drift, 100.0 + held, options.from_s});
    for (std::size_t taxel = 0; taxel < width; ++taxel) {
      const double over_zero = output_up(example, taxel, options.level_psi) - zero_of(example, taxel);
      const double pushed =
          0.5 * drift *
          (output_up(example, taxel, options.level_psi + 1.0) - output_up(example, taxel, options.level_psi - 1.0));
      repeat.volts.push_back(zero_of(example, taxel) + over_zero * (1.0 + options.per_decade * std::log10(held)) +
                             pushed);
    }
  }
  run.run = 77;
  run.sequences = {{"creep-hold", {repeat}}};
  return run;
}

// As a calibration whose frames are taken 2 s after their level was commanded.
inline Dataset read_after(Dataset dataset, double held_s) {
  for (SequenceData& data : dataset.sequences)
    for (Repeat& repeat : data.repeats)
      for (Sample& step : repeat.steps) step.held_s = held_s;
  return dataset;
}

// The calibration's own outputs as they would be at another temperature: every output over the first taxel's zero times
// (1 + share), and zero_v more; `repeat_share` more in the second of three repeats and less in the third.
inline Dataset at_temperature(const Example& example, double celsius, double share, double zero_v,
                              double repeat_share = 0.0) {
  Dataset run = example.dataset;
  run.temperatures_c = {celsius - 0.1, celsius + 0.1};
  const std::size_t width = example.fit.array().size();
  for (SequenceData& data : run.sequences)
    for (std::size_t r = 0; r < data.repeats.size(); ++r)
      for (std::size_t i = 0; i < data.repeats[r].volts.size(); ++i) {
        const double own = share + repeat_share * (r == 1 ? 1.0 : r == 2 ? -1.0 : 0.0);
        double& volts = data.repeats[r].volts[i];
        volts += own * (volts - zero_of(example, i % width)) + zero_v;
      }
  return run;
}

}  // namespace effect_runs
