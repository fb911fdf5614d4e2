// Scores a model on histories, preferably ones that it was not fitted to: the direct model's error, and the error of
// the input recovered by the inverse model; a stored model taxel by taxel, and a model cross-validated on branches that
// it was not fitted to.
#pragma once

#include <span>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/stored/model_document.h"

namespace tactbench::analysis {

// Mean and maximum of absolute errors.
struct ErrorSum {
  double sum = 0.0, max = 0.0;
  int samples = 0;
  void add(double error);
  void add(const ErrorSum& other);
  [[nodiscard]] double mean() const { return samples > 0 ? sum / samples : 0.0; }
};

// Compensation errors of samples between two bounds of hold time or rate; both ends of a decade in thirds.
struct Bin {
  double low = 0.0, high = 0.0;
  ErrorSum error;
};

struct Score {
  // |model - measured output| [Eq. 49], output's unit: each branch from its measured start, as the paper compares
  // models (those whose output is a function of the inputs alone take no notice), and from the first input on alone.
  ErrorSum direct, free_running;
  ErrorSum compensated;  // |inverse model - measured input|, input's unit
  ErrorSum raw;          // the same for one straight line through the ends of the external loop: no compensation
  std::vector<Bin> by_hold, by_rate;  // seconds; input units a second; where the histories have times
  void add(const Score& other);
  // One sample's compensation error, with its bins; a hold or rate of 0 is in none.
  void add_sample(double error, double hold_s, double rate);
};

struct ScoreOptions {
  double noise = 0.0;                                           // standard deviation of an output
  double x_low = 0.0, y_low = 0.0, x_high = 1.0, y_high = 1.0;  // ends of the external loop
};

// A branch's first sample, its turning point, does not count. A history that begins at the lowest input (within 1 % of
// the span) begins at rest, the inverse of any other from an unknown state.
Score score(const HysteresisModel& model, std::span<const History> histories, const ScoreOptions& options);

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
