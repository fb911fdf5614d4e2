// A stored model scored on histories, taxel by taxel, and a model cross-validated on branches it was not fitted to.
#pragma once

#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/scoring/score.h"

namespace tactbench::analysis {

struct ModelScore {
  Score taxels;             // sums over all taxels that have a model
  Score mean;               // of the mean taxel; of the only one when there is one
  double full_scale = 0.0;  // what the mean taxel's loop spans (ModelFit::full_scale)
  int count = 0;            // taxels in the first
  [[nodiscard]] bool worse_than_line() const { return taxels.compensated.mean() > taxels.raw.mean(); }
};

// Checks that a model applies to the data. Throws AnalysisError TB-ANALYSIS-OTHER-SENSOR when sensor or scanner differ,
// TB-ANALYSIS-ORIGIN when the origins do, TB-MODEL-UNITS when the units do, TB-ANALYSIS-FALLING when the signs do.
void check_same_source(const SensorModel& document, const Histories& histories);

// On the named sequences (empty: all). Of a model with lag and creep the direct model's errors are those of its static
// film, creep and lag removed at the inputs measured. Its compensated errors, and all models' of a table, are those of
// `compensate`; of others one rule applies to all inverses. Throws as check_same_source and
// histories_without_dynamics, and TB-ANALYSIS-NO-TAXEL.
ModelScore score_model(const SensorModel& document, const Histories& histories,
                       const std::vector<std::string>& sequences, int threads = 0);

// Inner branches are dealt into `folds`; each fold is predicted by a model fitted on all the others and on the external
// loop. Errors of the direct model on branches that were not fitted; no samples when there are fewer than two inner
// ones.
ErrorSum cross_validate(const std::string& model, const FitData& data, const IdentifyOptions& options, int folds = 5);

}  // namespace tactbench::analysis
