// The page around a document's parts: head, policy, style, banner, list of contents, end, data.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/report/page/html.h"
#include "analysis/report/page/style.h"

namespace tactbench::analysis {

struct Page {
  std::string document;  // "Calibration report": letters and spaces
  std::string number;    // digits, a-f and hyphens
  std::string title;     // stands after the document's name; empty: the number
  bool simulated = false;
  PaperSize paper = PaperSize::kA4;
  html::Markup opening;                                       // below the number
  std::vector<std::pair<std::string, std::string>> contents;  // id and title; empty: no list
  std::vector<html::Markup> main;
  std::string_view json;  // in ASCII
};

std::string page_of(const Page& page);

}  // namespace tactbench::analysis
