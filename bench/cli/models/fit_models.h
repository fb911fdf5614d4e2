// `fit` with other models than ELAM in the paper's mode, on tables, or with chosen sequences: fits each model, scores
// it on what it was not fitted to, prints them side by side, stores them.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/fit_data.h"
#include "bench/cli/runs/source.h"

namespace tactbench::bench {

struct FitModelsOptions {
  std::string source;  // run or table
  std::vector<std::string> models, fit,
      score;  // score: sequences of the source, runs, tables; empty: what was not fitted
  analysis::IdentifyOptions identify;
  std::string mount, interface_material;  // for the model's validity
  TableOptions table;
  std::string output;       // file of the one model
  bool mean_taxel = false;  // that one alone
};

void fit_models(const FitModelsOptions& options, Session& session);

// fit --check MODEL: what the model is worth on a later run.
void check_model(const std::string& model, const FitModelsOptions& options, Session& session);

}  // namespace tactbench::bench
