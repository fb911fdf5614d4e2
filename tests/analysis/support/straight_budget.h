// Input of an uncertainty budget in which only scatter counts: taxels that are straight lines, and a reference without
// a row.
#pragma once

#include <utility>
#include <vector>

#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/straight_array.h"

namespace straight_array {

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
