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
  std::string state;     // printed at the foot of each page
  bool simulated = false;
  PaperSize paper = PaperSize::kA4;
};

// Document, number and SIMULATED are in the margins of each printed page. Throws std::invalid_argument if document or
// number contain other characters than stated above.
html::Markup style_sheet(const StyleOptions& options);

// The same without page margins, for pages that are not reports.
html::Markup plain_style_sheet();

// Only the rules for charts, for an SVG file.
html::Markup chart_rules();

struct Page {
  std::string document = {};  // "Calibration report": letters and spaces
  std::string number = {};    // digits, a-f and hyphens
  std::string title = {};     // follows the document's name; empty: the number
  std::string state = {};     // "draft, not issued"; printed at the foot of each page
  bool simulated = false;
  PaperSize paper = PaperSize::kA4;
  html::Markup body = {};
  std::string_view json = {};  // in ASCII: identifies the page; the data are in a separate file
};

std::string page_of(const Page& page);

}  // namespace tactbench::analysis
