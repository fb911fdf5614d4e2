// The report of an imported table: its loop, its models and their errors. No rig, no verdict, no uncertainty.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report.h"
#include "analysis/statistics/scoring/score.h"

namespace tactbench::analysis {

struct TableReportInput {
  db::RunRecord run;
  Histories histories;
  std::vector<SensorModel> models;  // stored models, the newest last; may be empty
  std::vector<ModelScore> scores;   // of each model on these data
  PaperSize paper = PaperSize::kA4;
  PressureUnit unit;
};

Report render_table_report(const TableReportInput& input);
// The models and their errors, for a terminal of `columns`.
doc::Document summary_of(const TableReportInput& input, PressureUnit unit);

}  // namespace tactbench::analysis
