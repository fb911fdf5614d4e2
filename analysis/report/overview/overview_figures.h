// Shared by the pages on several runs: figures, limits and verdicts of one run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis {

// One figure of a run as a row of a table.
struct OverviewFigure {
  const char* name;                     // name of the row with its unit; for a pressure without unit: name_of()
  const char* key;                      // in the data
  double (*value)(const ReportInput&);  // NaN if there is none
  int digits;                           // decimals of the displayed value
  double factor;                        // value in the data x factor = displayed value
  const char* criterion;                // criterion that limits it; empty: none
};
const std::vector<OverviewFigure>& overview_figures();
bool is_pressure(const OverviewFigure& figure);
std::string name_of(const OverviewFigure& figure, PressureUnit unit);  // with its unit
doc::Quantity shown_figure(const OverviewFigure& figure, double value);
// The number for a chart: value x factor, a pressure in `unit`.
double plotted_figure(const OverviewFigure& figure, double value, PressureUnit unit);
// The figure's limit in the run's verdicts, in the unit of the data; NaN without one.
double limit_of(const OverviewFigure& figure, const ReportInput& input);

std::string content_of_run(const ReportInput& input);  // JSON: run, sensor, origin, content hash, figures; no times
doc::Phrase overall_phrase(const ReportInput& input, const char* without_limits);

doc::Document loops_overlaid(const std::vector<const ReportInput*>& runs);
std::string sensor_and_run(const ReportInput& input);  // "SIM-0001, run 3"

// Charts of a measured loop with the loops of models drawn over it, and of a model's residuals: for the mean taxel, or
// the only taxel.

// `models`: made from or checked on these data; the first four are drawn. Pressures in `unit`, other inputs in their
// own unit.
Chart fitted_loop(const Histories& histories, const std::vector<const SensorModel*>& models, PressureUnit unit);
// Measured outputs minus the model's, in % of full scale, over the inputs.
Chart fitted_errors(const Histories& histories, const SensorModel& model, PressureUnit unit);

}  // namespace tactbench::analysis
