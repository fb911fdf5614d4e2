// `fit`: fits each model on a run or table, scores it on what it was not fitted to, prints it, judges it, stores it.
// One way for every model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/identify/fit_data.h"
#include "bench/cli/runs/source.h"

namespace tactbench::bench {

struct FitModelsOptions {
  std::string source;  // run or table
  std::vector<std::string> models, fit,
      score;                           // score: sequences of the source, runs, tables; empty: what was not fitted
  std::vector<std::int64_t> held_out;  // runs that figures are taken on, too
  std::string limits, lab;             // files
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
