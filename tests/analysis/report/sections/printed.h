// What a section prints, piece by piece: rows of tables, charts with the data given, pressures in psi.
#pragma once

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "tests/analysis/report/report_page.h"

namespace tactbench::analysis::printed {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

inline std::string psi(double pressure, int digits) {
  return html::pressure(pressure, PressureUnit::kPsi, digits).value;
}

inline std::string numbers(const std::vector<std::string>& cells) {
  std::string out;
  for (const std::string& cell : cells) out += "<td class=\"n\">" + cell + "</td>";
  return out;
}

// A row of numbers behind its head.
inline std::string row(const std::string& head, const std::vector<std::string>& cells) {
  return "<tr><th scope=\"row\">" + head + "</th>" + numbers(cells) + "</tr>";
}

// A level of a table: its pressure in psi and in kPa, as printed.
inline std::string level_head(const std::string& in_psi, const std::string& in_kpa) {
  return "<tr><th scope=\"row\" class=\"n\">" + in_psi + "</th><td class=\"n\">" + in_kpa + "</td>";
}

inline void check_once(const std::string& page, const std::string& part) {
  INFO(part);
  CHECK(count(page, part) == 1);
}

inline void check_none(const std::string& page, const std::string& part) {
  INFO(part);
  CHECK(count(page, part) == 0);
}

// The chart as it must be drawn, its axes in psi.
inline void check_along(const std::string& page, const LineChart& chart) {
  INFO(chart.title);
  CHECK(count(page, line_chart(pressure_along(chart, PressureUnit::kPsi)).value) == 1);
}
inline void check_both(const std::string& page, const LineChart& chart) {
  INFO(chart.title);
  CHECK(count(page, line_chart(pressures(chart, PressureUnit::kPsi)).value) == 1);
}

}  // namespace tactbench::analysis::printed
