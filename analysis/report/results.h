// Results of a report beyond its evaluation: the previous models, further runs. All are computed before rendering, so
// that rendering stays fast.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/judgement/judgement.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/studies/contact.h"
#include "analysis/statistics/studies/studies.h"
#include "db/record.h"

namespace tactbench::analysis {

// The run evaluated with earlier models (as found).
struct AsFound {
  std::string model;  // as named on the command line
  Evaluation evaluation;
  int fitted_taxels = 0;
  Judgement judgement;  // by the limits of the report
  // If the judgement is fail: a sentence that states since when measurements are in doubt. Without run numbers.
  std::string doubt;
};

struct ReportResults {
  std::optional<AsFound> previous;
  Studies studies;
  std::vector<ContactResult> contacts;
};

// `dataset` evaluated with `previous`, except for the taxels that `fit` omits, so that as found and as left refer to
// the same taxels. Throws AnalysisError as evaluate().
AsFound as_found_with(const Dataset& dataset, const SensorModel& fit, const SensorModel& previous,
                      const std::string& previous_name, int threads = 0);

}  // namespace tactbench::analysis
