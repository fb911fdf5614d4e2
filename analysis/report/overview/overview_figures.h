// Shared by the pages on several runs: figures, limits and verdicts of one run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/parts.h"

namespace tactbench::analysis {

// One figure of a run as a row of a table.
struct OverviewFigure {
  const char* name;                     // of the row, with its unit; of a pressure without: name_of()
  const char* key;                      // in the data
  double (*value)(const ReportInput&);  // NaN where there is none
  int digits;                           // of the value shown
  double factor;                        // value in the data x factor = value shown
  const char* criterion;                // of a verdict that limits it; empty: none
};
const std::vector<OverviewFigure>& overview_figures();
bool is_pressure(const OverviewFigure& figure);
std::string name_of(const OverviewFigure& figure, PressureUnit unit);  // with its unit
doc::Quantity shown_figure(const OverviewFigure& figure, double value);
// The figure alone, as in a chart: value x factor, a pressure in `unit`.
double plotted_figure(const OverviewFigure& figure, double value, PressureUnit unit);
// The figure's limit in the run's verdicts, in the unit of the data; NaN without one.
double limit_of(const OverviewFigure& figure, const ReportInput& input);

std::string content_of_run(const ReportInput& input);  // JSON: run, sensor, origin, content hash, figures; no times
doc::Phrase overall_phrase(const ReportInput& input, const char* without_limits);

doc::Document loops_overlaid(const std::vector<const ReportInput*>& runs);
std::string sensor_and_run(const ReportInput& input);  // "SIM-0001, run 3"

}  // namespace tactbench::analysis
