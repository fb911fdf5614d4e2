// The page around a document: head, policy, style, banner, end, data.
#pragma once

#include <string>
#include <string_view>

#include "analysis/report/page/html.h"

// The report's style sheet: screen and paper, tables and flex only (one of the PDF engines has no grid layout).

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

struct Page {
  std::string document = {};  // "Calibration report": letters and spaces
  std::string number = {};    // digits, a-f and hyphens
  std::string title = {};     // stands after the document's name; empty: the number
  std::string state = {};     // "draft, not issued"; at the foot of each page
  bool simulated = false;
  PaperSize paper = PaperSize::kA4;
  html::Markup body = {};
  std::string_view json = {};  // in ASCII: what tells whose page it is; the data stand beside it
};

std::string page_of(const Page& page);

}  // namespace tactbench::analysis
