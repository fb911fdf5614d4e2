// `fit`: fits each model to a run or table, scores it on other data, prints, judges and stores it. The same procedure
// for every model.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/report/document/document.h"
#include "bench/cli/runs/source.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

struct FitModelsOptions {
  std::string source;        // run or table
  std::string verb = "fit";  // of the JSON document
  // models: empty: the dynamic model, or ELAM for data that it does not accept. score: sequences of the source, runs,
  // tables; empty: the sequences that were not fitted.
  std::vector<std::string> models, fit, score;
  std::string elam_reason;                   // why ELAM is made if no model is named; empty: the data decide
  std::vector<std::int64_t> held_out;        // runs on which figures are computed, too
  std::int64_t rate_run = 0, creep_run = 0;  // of the dynamic model; 0: not named
  std::string limits, lab;                   // files
  analysis::IdentifyOptions identify;
  std::string mount, interface_material;  // for the model's validity
  TableOptions table;
  std::string output, plot, html;  // files: the one model; loop and models as SVG; comparison of the models
  bool mean_taxel = false;         // fits only the mean taxel
};

void fit_models(const FitModelsOptions& options, Session& session);

// One model of a run of the bench, with its figures and its judgement.
struct JudgedFit {
  analysis::SensorModel model;
  std::vector<NamedEvaluation> evaluations;  // the first is of the run itself, then the held-out runs in turn
  analysis::Judgement judgement;             // empty without limits
};
// Fits and stores as fit_models() does, but prints only warnings. `options` names at most one model, a run of the
// bench, and nothing to score. Sets session.code by the judgement.
JudgedFit fit_and_judge(const FitModelsOptions& options, Session& session);

// model check: how well the model describes a later run.
void check_model(const std::string& model, const FitModelsOptions& options, Session& session);

// Output of `fit` for one fitted model of a run: headline, figures, verdicts.
struct Session;

struct FittedRun {
  const analysis::SensorModel* model = nullptr;
  std::vector<NamedEvaluation> evaluations;  // the first is of the run itself
  analysis::Judgement judgement;             // empty without limits
};

// Lines without a line end. linearised_text(): for how many taxels the readout divider is inverted, and with which c.
// dynamics_text(): whether lag and creep are compensated. Empty where the model has neither.
std::string linearised_text(const analysis::SensorModel& fit);
std::string dynamics_text(const analysis::SensorModel& fit);

struct LeftOut {
  int taxel = 0, row = 0, column = 0;
  std::string status, why;
};
// Each taxel without a model, in the order of their numbers.
std::vector<LeftOut> left_out_of(const analysis::SensorModel& fit);

// Prints the document; with -q only the verdict of a judged model.
void print_fitted(const FittedRun& fitted, const Session& session);
// Adds the members for --json to `json`.
void add_fitted_json(const FittedRun& fitted, nlohmann::ordered_json& json);

}  // namespace tactbench::bench
