// Tables of models: the data to which each was fitted, and its errors on other data.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "analysis/report/document/document.h"
#include "analysis/statistics/scoring/score.h"

namespace tactbench::bench {

// Data on which models are scored.
struct ScoreTarget {
  std::string title;
  const analysis::Histories* histories = nullptr;
  std::vector<std::string> sequences;  // empty: all
};

struct ModelRow {
  std::string label;
  analysis::SensorModel document;
  analysis::ErrorSum crossed;                // of the displayed taxel, by cross_validate(); no samples: not computed
  std::vector<analysis::ModelScore> scores;  // one per target
};

// A model that cannot be fitted to the data, and why.
struct ModelRefusal {
  std::string model, why;
};

// Fits each model on the named sequences (empty: all) and scores it on each target. With `refusals` a model that cannot
// be fitted to the data is listed there, as long as another one can. `begun` is called with the name of each model
// before its fit. Throws AnalysisError.
std::vector<ModelRow> model_rows(const std::vector<std::string>& models, const analysis::Histories& histories,
                                 const std::vector<std::string>& sequences, const analysis::IdentifyOptions& options,
                                 const std::vector<ScoreTarget>& targets, std::vector<ModelRefusal>* refusals = nullptr,
                                 const std::function<void(const std::string&)>& begun = {});

// Fills in the cross-validation columns of the table. Throws AnalysisError.
void cross_validate(std::vector<ModelRow>& rows, const analysis::Histories& histories,
                    const std::vector<std::string>& sequences);

// The parameters that the data do not determine, with the number of taxels concerned (the mean taxel of an array is not
// counted), as one line with a line end; empty if all are determined.
std::string undetermined_text(const analysis::SensorModel& document);
// Taxels without a usable model, with the reason, one line each; empty if all are fitted.
std::string left_out_text(const analysis::SensorModel& document);
// True when the model of any taxel has too large an error, or a taxel has no model.
bool any_unfit(const analysis::SensorModel& document);
// `all`: also the parameters, the largest errors and the errors of the direct model.
analysis::doc::Document fits_document(const std::vector<ModelRow>& rows, bool all);
analysis::doc::Document scores_document(const std::vector<ModelRow>& rows, const std::vector<ScoreTarget>& targets,
                                        const std::string& unit_of_input, analysis::PressureUnit shown, bool all);
nlohmann::ordered_json model_row_json(const ModelRow& row, const std::vector<ScoreTarget>& targets);

}  // namespace tactbench::bench
