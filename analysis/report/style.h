// The report's style sheet: screen and paper, tables and flex only (one of the PDF engines has no grid layout).
#pragma once

#include <string>

#include "analysis/report/html.h"

namespace tactbench::analysis {

// `number` and SIMULATED stand in the margins of each printed page. Throws std::invalid_argument when `number` holds
// anything but digits, a-f and hyphens.
html::Markup style_sheet(const std::string& number, bool simulated);

// The same without page margins, for pages that are no report.
html::Markup plain_style_sheet();

}  // namespace tactbench::analysis
