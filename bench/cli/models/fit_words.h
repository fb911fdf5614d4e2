// Output of `fit` for one fitted model of a run: headline, figures, verdicts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/report/document/document.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

struct Session;

struct FittedRun {
  const analysis::SensorModel* model = nullptr;
  std::vector<NamedEvaluation> evaluations;  // the first is the run's own
  analysis::Judgement judgement;             // empty without limits
};

// Lines without a line end. linearised_text(): for how many taxels the readout divider is inverted, and by which c.
// dynamics_text(): whether lag and creep are compensated. Empty where the model has neither.
std::string linearised_text(const analysis::SensorModel& fit);
std::string dynamics_text(const analysis::SensorModel& fit);

struct LeftOut {
  int taxel = 0, row = 0, column = 0;
  std::string status, why;
};
// Each taxel without a model, in the order of their numbers.
std::vector<LeftOut> left_out_of(const analysis::SensorModel& fit);

// The verdict first, then the model and its figures. `all`: every check, and the mean taxel's parameters.
analysis::doc::Document fitted_document(const FittedRun& fitted, analysis::PressureUnit unit, bool all);
// Prints the document; with -q only the verdict of a judged model.
void print_fitted(const FittedRun& fitted, const Session& session);
// Adds the members for --json to `json`.
void add_fitted_json(const FittedRun& fitted, nlohmann::ordered_json& json);

}  // namespace tactbench::bench
