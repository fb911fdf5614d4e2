// The page around a document: head, policy, style, banner, end, data.
#pragma once

#include <string>
#include <string_view>

#include "analysis/report/page/html.h"
#include "analysis/report/page/style.h"

namespace tactbench::analysis {

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
