// Three taxels whose figures can all be computed by hand. Models: straight lines of 20 and 10 psi a volt, the same up
// and down, so that whatever the history, pressure = line x output; the third taxel is dead. Data: loops in psi as the
// models read them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/specimen_taxels.h"

namespace straight_array {

using namespace tactbench::analysis;

inline constexpr double kPsiPerVolt[] = {20.0, 10.0};
inline constexpr double kFullPsi = 60.0;
inline const std::vector<double> kLevels{0.0, 20.0, 40.0, 60.0};

// The split points of ELAM's inner curves lie on the line too: halves of the way are halves of the output.
inline ModelTaxel straight_taxel(double psi_per_volt) {
  const std::vector<double> ends{0.0, kFullPsi}, volts{0.0, kFullPsi / psi_per_volt};
  const PatternCurve line(ends, volts, volts.front(), volts.back());
  return by_hand::elam_taxel(line, line);
}

// The mean of 3 V and 6 V at 60 psi is 4.5 V: 40/3 psi a volt.
inline SensorModel straight_fit() {
  SensorModel fit;
  fit.rows = 1;
  fit.columns = 3;
  fit.run = 1;
  fit.origin = "simulated";
  fit.sensor_serial = "S";
  fit.pressure_psi = kLevels;
  fit.taxels = {straight_taxel(kPsiPerVolt[0]), straight_taxel(kPsiPerVolt[1]), by_hand::left_out(TaxelStatus::kDead)};
  by_hand::finish(fit, straight_taxel(kFullPsi / 4.5));
  return fit;
}

// The reading of each taxel at each step.
struct Readings {
  std::vector<double> first_psi, second_psi;
};

inline Repeat repeat_of(const std::vector<Sample>& steps, const Readings& readings, double dead_v = 5.0) {
  Repeat repeat{steps, {}};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    repeat.volts.push_back(readings.first_psi[i] / kPsiPerVolt[0]);
    repeat.volts.push_back(readings.second_psi[i] / kPsiPerVolt[1]);
    repeat.volts.push_back(dead_v);  // so far off that it shows where it is not left out
  }
  return repeat;
}

// Once along the set-points: what the taxels read more than the reference everywhere but at the range's ends.
inline Repeat offset_way(const std::vector<double>& setpoints, double first_off, double second_off,
                         double held_s = 1.0) {
  std::vector<Sample> steps;
  Readings readings;
  for (const double psi : setpoints) {
    const bool end = psi == 0.0 || psi == kFullPsi;
    steps.push_back({psi, psi, 0.0, held_s});
    readings.first_psi.push_back(psi + (end ? 0.0 : first_off));
    readings.second_psi.push_back(psi + (end ? 0.0 : second_off));
  }
  return repeat_of(steps, readings);
}

// Once along the set-points for each row of errors, step by step: of the first taxel, the second's are half of them.
// Held for as long as the repeat says, or a second.
inline SequenceData erring_way(const std::string& name, const std::vector<double>& setpoints,
                               const std::vector<std::vector<double>>& error_by_repeat,
                               const std::vector<double>& held_s = {}) {
  SequenceData sequence{name, {}};
  for (std::size_t repeat = 0; repeat < error_by_repeat.size(); ++repeat) {
    std::vector<Sample> steps;
    Readings readings;
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      steps.push_back({setpoints[i], setpoints[i], 0.0, held_s.empty() ? 1.0 : held_s[repeat]});
      readings.first_psi.push_back(setpoints[i] + error_by_repeat[repeat][i]);
      readings.second_psi.push_back(setpoints[i] + 0.5 * error_by_repeat[repeat][i]);
    }
    sequence.repeats.push_back(repeat_of(steps, readings));
  }
  return sequence;
}

inline Dataset dataset_of(std::vector<SequenceData> sequences) {
  Dataset dataset;
  dataset.run = 2;
  dataset.origin = "simulated";
  dataset.sensor_serial = "S";
  dataset.rows = 1;
  dataset.columns = 3;
  dataset.noise_v.assign(3, 0.0);
  dataset.at_limit.assign(3, false);
  dataset.sequences = std::move(sequences);
  return dataset;
}

// Up and down over the levels, twice. Set-point and reference are one but at 40 psi on the way up, where the chamber
// stands at 41 and the taxels say so. On the way down the first taxel reads 1 psi too little at 40 and 6 too much at
// 20 (5 and 7 in the two repeats), the second 3 and 1 too much.
inline Dataset known_loop() {
  const std::vector<Sample> steps{{0, 0}, {20, 20}, {40, 41}, {60, 60}, {40, 40}, {20, 20}, {0, 0}};
  const std::vector<double> second{0, 20, 41, 60, 43, 21, 0};
  return dataset_of({{"loop",
                      {repeat_of(steps, {{0, 20, 41, 60, 39, 25, 0}, second}),
                       repeat_of(steps, {{0, 20, 41, 60, 39, 27, 0}, second})}}});
}

// Input of an uncertainty budget in which only scatter counts: taxels that are straight lines, and a reference without
// a row.

inline ReferenceUncertainty no_reference() {
  ReferenceUncertainty reference;
  reference.certificate_missing = reference.drift_missing = reference.resolution_missing = "none";
  return reference;
}

// Calibrated by the sequences. A maker looks at what stands here.
struct StraightBudget {
  Dataset calibration;
  SensorModel fit = straight_fit();
  SweepErrors errors;
  ReferenceUncertainty reference = no_reference();
  UncertaintyInputs inputs;
  explicit StraightBudget(std::vector<SequenceData> sequences) : calibration(dataset_of(std::move(sequences))) {
    errors = sweep_errors(calibration, fit);
  }
  [[nodiscard]] BudgetMaker maker() const { return {calibration, fit, errors, reference, 0.0, inputs, 1}; }
};

}  // namespace straight_array
