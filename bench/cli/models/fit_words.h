// One fitted model of a run as `fit` says it: headline, figures, verdicts.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

struct FittedRun {
  const analysis::SensorModel* model = nullptr;
  std::vector<NamedEvaluation> evaluations;  // the first is the run's own
  Judgement judgement;                       // empty without limits
};

std::string fitted_text(const FittedRun& fitted);
// Adds what a program wants of it to `json`.
void add_fitted_json(const FittedRun& fitted, nlohmann::ordered_json& json);

}  // namespace tactbench::bench
