// The table of models: what each was fitted to, and how well it does on what it was not fitted to.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/statistics/scoring/model_score.h"

namespace tactbench::bench {

// What models are scored on.
struct ScoreTarget {
  std::string title;
  const analysis::Histories* histories = nullptr;
  std::vector<std::string> sequences;  // empty: all
};

struct ModelRow {
  std::string label;
  analysis::ModelDocument document;
  analysis::ErrorSum crossed;                // of the shown taxel
  std::vector<analysis::ModelScore> scores;  // a target each
  std::int64_t fit = 0;                      // number in the store; 0: not stored
};

// Fits each model on the named sequences (empty: all) and scores it on each target. Throws AnalysisError.
std::vector<ModelRow> model_rows(const std::vector<std::string>& models, const analysis::Histories& histories,
                                 const std::vector<std::string>& sequences, const analysis::IdentifyOptions& options,
                                 const std::vector<ScoreTarget>& targets);

std::string fits_table(const std::vector<ModelRow>& rows);
std::string scores_table(const std::vector<ModelRow>& rows, const std::vector<ScoreTarget>& targets,
                         const std::string& input_unit);
nlohmann::ordered_json model_row_json(const ModelRow& row, const std::vector<ScoreTarget>& targets);

}  // namespace tactbench::bench
