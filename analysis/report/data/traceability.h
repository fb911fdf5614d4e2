// To which standards a report's quantities are traced, and what is to be said of the instruments beside the verdict.
// The certificates and dates are those of instrument_calibration.h everywhere.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/report/page/html.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

struct Traceability {
  std::string title;      // "traceability of the force"
  std::string statement;  // "Force not traceable: ..."
  bool traceable = false;
};

// Force and place of a run that pressed objects; pressure of one that used the chamber.
std::vector<Traceability> traceability_of(const ReportInput& input);
Traceability force_traceability(const db::RunRecord& run, std::span<const InstrumentNote> notes);
std::string traceability_json(const ReportInput& input);

// For page 1: instruments that were overdue when the report's runs were made, and contradictions about them. Empty:
// nothing to say.
html::Markup instruments_warning(const ReportInput& input);
// Beside an overall verdict of inconclusive: "reference overdue since ...". Empty: that is not why.
std::string reason_of_verdict(const ReportInput& input);

}  // namespace tactbench::analysis
