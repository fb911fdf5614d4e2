// A report's results beyond fit, evaluations and verdicts: model comparison, previous models, further runs.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/gather.h"
#include "analysis/report/report.h"

namespace tactbench::bench {

struct ReportExtras {
  std::string previous;              // MODEL: path of a .json, or RUN[:FIT]; empty: none
  std::vector<std::string> studies;  // RUN or RUN:ROLE
  analysis::Laboratory laboratory = {};
  analysis::PressureUnit unit = {};  // of the page
};

// A further run of the sensor. Its purpose follows from its recipes (presses under an object, several rates, holds) or
// from its thermometer (another temperature). For other plain loops the purpose is typed as a role: mount (mounted
// again), or 0, 90, 180, 270 (turned in the chamber by that many degrees counter-clockwise, row 0 on top).
struct StudyRun {
  std::int64_t run = 0;
  std::string role;  // mount, 0, 90, 180, 270; empty: derived from recipes or temperature
};
// Throws Error TB-USAGE.
std::vector<StudyRun> study_runs_of(const std::vector<std::string>& words);

// Fills in input.more; run, fit and evaluation must be filled in before. Without an evaluation, adds only the results
// that need none: the run's own presses, and studies. Throws Error TB-REPORT-STUDY for a run with unknown role,
// AnalysisError, StoreError.
void add_results(analysis::ReportInput& input, analysis::Runs& runs, const ReportExtras& extras);

// Judges a sensor as found, before adjustment: the data of this run with the models that were in use before it, by the
// report's limits.

// The sensor's models from before `run`, as RUN:FIT; empty: the store has none, or they do not fit the run (another
// scanner), or they are based on it.
std::string models_before(analysis::Runs& runs, std::int64_t run);

// Fills in `judgement` and `doubt` of input.more.previous, if there are earlier models (`previous`, as named) and the
// report is judged by `limits`. If the verdict is fail, measurements since the sensor's last passed calibration are in
// doubt.
void judge_as_found(analysis::Runs& runs, analysis::ReportInput& input, const std::string& previous,
                    const analysis::Limits& limits);

}  // namespace tactbench::bench
