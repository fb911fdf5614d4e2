// Traceability of a report's quantities, and warnings about instruments to print with the verdict. Certificates and
// dates come from instruments.h.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/report/report.h"

namespace tactbench::analysis {

struct Traceability {
  std::string title;      // "traceability of the force"
  std::string statement;  // "Force not traceable: ..."
  bool traceable = false;
};

// Force and position for a run that pressed objects; pressure for one that used the chamber.
std::vector<Traceability> traceability_of(const ReportInput& input, PressureUnit unit);
Traceability force_traceability(const db::RunRecord& run, std::span<const InstrumentNote> notes);
std::string traceability_json(const ReportInput& input);

// For page 1: instruments that were overdue when the report's runs were made, and contradictions about them.
std::vector<std::string> instrument_warnings(const ReportInput& input);
}  // namespace tactbench::analysis
