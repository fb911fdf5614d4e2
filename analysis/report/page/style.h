// The report's style sheet: screen and paper, tables and flex only (one of the PDF engines has no grid layout).
#pragma once

#include <string>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

enum class PaperSize { kA4, kLetter };

struct StyleOptions {
  std::string document;  // "Calibration report": letters and spaces
  std::string number;    // digits, a-f and hyphens
  std::string state;     // at the foot of each page
  bool simulated = false;
  PaperSize paper = PaperSize::kA4;
};

// Document, number and SIMULATED stand in the margins of each printed page. Throws std::invalid_argument when document
// or number hold anything else than said above.
html::Markup style_sheet(const StyleOptions& options);

// The same without page margins, for pages that are no report.
html::Markup plain_style_sheet();

// What charts alone need of it, for an SVG file.
html::Markup chart_rules();

}  // namespace tactbench::analysis
