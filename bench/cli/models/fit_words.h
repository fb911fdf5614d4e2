// One fitted model of a run as `fit` prints it: headline, figures, verdicts.
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

// How many taxels have the readout divider undone, and by which c; whether lag and creep are. A line each, without its
// end; empty where the model has none.
std::string linearised_text(const analysis::SensorModel& fit);
std::string dynamics_text(const analysis::SensorModel& fit);

struct LeftOut {
  int taxel = 0, row = 0, column = 0;
  std::string status, why;
};
// Each taxel that no model was made for, in the order of their numbers.
std::vector<LeftOut> left_out_of(const analysis::SensorModel& fit);

// The verdict first, then the model and its figures. `all`: every check, and the mean taxel's parameters.
analysis::doc::Document fitted_document(const FittedRun& fitted, analysis::PressureUnit unit, bool all);
// Prints it; of a judged one with -q the verdict alone.
void print_fitted(const FittedRun& fitted, const Session& session);
// Adds what a program wants of it to `json`.
void add_fitted_json(const FittedRun& fitted, nlohmann::ordered_json& json);

}  // namespace tactbench::bench
