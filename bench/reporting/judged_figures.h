// What judge() takes beside an evaluation: U of each judged figure, and the figures of [[mpe]].
#pragma once

#include <vector>

#include "analysis/report/runs.h"
#include "analysis/statistics/conformity/mpe.h"
#include "analysis/statistics/conformity/verdict.h"

namespace tactbench::bench {

struct JudgedFigures {
  std::vector<analysis::JudgedUncertainty> uncertainties;  // empty where the rule needs none
  std::vector<analysis::MpeFigure> mpe;                    // one for each of the limits
};

// Of `evaluation`, with the models of `fit`; `reference` is that of its run. U of a reading is that of the models' run
// without further runs (studies), so that stored verdicts do not depend on a report's.
JudgedFigures judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                             const analysis::ReferenceUncertainty& reference);

}  // namespace tactbench::bench
