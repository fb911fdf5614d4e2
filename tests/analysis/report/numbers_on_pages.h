// Every number on a page in sums, each with a weight of its own; how many there are, how many tags, and how many marks.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "tests/analysis/report/report_page.h"

namespace tactbench::analysis::pages_in_numbers {

struct PrintedNumbers {
  std::string part;
  double sum = 0.0;
  std::size_t numbers = 0, tags = 0, marks = 0;
};

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Each number has a weight of its own. A colour is a number of six hexadecimal digits.
inline PrintedNumbers numbers_on(const std::string& part, const std::string& text) {
  PrintedNumbers found{part};
  for (std::size_t at = 0; at < text.size(); ++at) {
    double value = 0.0;
    if (text[at] == '#' && at + 6 < text.size() && text.find_first_not_of("0123456789abcdef", at + 1) == at + 7) {
      value = static_cast<double>(std::strtol(text.substr(at + 1, 6).c_str(), nullptr, 16)) / 1e4;
      at += 6;
    } else if (is_digit(text[at])) {
      const std::size_t end = std::min(text.find_first_not_of("0123456789.eE", at), text.size());
      value = std::strtod(text.substr(at, end - at).c_str(), nullptr);
      if (at > 0 && text[at - 1] == '-') value = -value;
      at = end - 1;
    } else {
      continue;
    }
    if (!(std::abs(value) < 1e6)) value = 1e6;  // digests, times
    found.sum += value * (1.0 + static_cast<double>(found.numbers * 37 % 101) / 101.0);
    ++found.numbers;
  }
  found.tags = count(text, "<") + count(text, "\":");
  for (const char* mark : {"▲", "✗", "✓", "–", "−", "not available", "not assessed", "null", "true"})
    found.marks += count(text, mark);
  return found;
}

inline void check_parts(const std::vector<PrintedNumbers>& now, const std::vector<PrintedNumbers>& was) {
  std::string lines;
  for (const PrintedNumbers& own : now)
    lines += fmt::format("{{\"{}\", {:.7f}, {}, {}, {}}},\n", own.part, own.sum, own.numbers, own.tags, own.marks);
  INFO("now:\n" << lines);
  CHECK(now.size() == was.size());
  for (std::size_t i = 0; i < std::min(now.size(), was.size()); ++i) {
    CAPTURE(now[i].part);
    CHECK(now[i].part == was[i].part);
    CHECK(now[i].numbers == was[i].numbers);
    CHECK(now[i].tags == was[i].tags);
    CHECK(now[i].marks == was[i].marks);
    CHECK(now[i].sum == Approx(was[i].sum).epsilon(1e-9).margin(1e-6));
  }
}

// The page between its head and its data, and the data; without its number, which is of the content's digest.
inline std::vector<PrintedNumbers> printed_on(Report report) {
  for (std::string* text : {&report.html, &report.json})
    for (std::size_t at = text->find(report.number); at != std::string::npos; at = text->find(report.number, at))
      text->erase(at, report.number.size());
  const std::size_t from = report.html.find("<main"), to = report.html.find("id=\"report-data\">");
  return {numbers_on("page", report.html.substr(from, to - from)), numbers_on("data", report.json)};
}

}  // namespace tactbench::analysis::pages_in_numbers
