// The report's pages, one function and one source file each: pure functions of the collected input.
#pragma once

#include <optional>
#include <string>

#include "analysis/report/data/reading_figures.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report.h"

namespace tactbench::analysis {

// Signatures stored for this report and for earlier reports of the same run.
struct Issue {
  std::string number, content_sha256, document;  // "Calibration report"
  std::string authorised_by, authorised_utc, issued, replaces, reason;
  [[nodiscard]] bool draft() const { return authorised_by.empty(); }
};

struct PageData {
  const ReportInput& input;
  std::optional<ReadingFigures> readings;
  Issue issue = {};
};

doc::Document front_page(const PageData& data);            // 1: summary for the customer
doc::Document item_and_instruments(const PageData& data);  // 2: item, instruments, conditions
doc::Document method_page(const PageData& data);           // 3: method, loops, pressures applied
doc::Document levels_page(const PageData& data);           // 4: error and U at every level
doc::Document array_page(const PageData& data);            // 5: maps, spread, as found and as left
doc::Document budget_page(const PageData& data);           // 6: budget, decision rule, statements, hashes
doc::Document contact_pages(const PageData& data);         // for runs that pressed; page 1 for a run without U
doc::Document studies_pages(const PageData& data);         // if there are studies
// By name: maps, taxels, models, parameters, events, hashes.
doc::Document annex(const PageData& data, const std::string& name);

// The chart of page 1, one panel per direction.
doc::SideBySide readings_chart(const ReadingFigures& readings, PressureUnit unit);
// "28 to 345 kPa"; "at 28 kPa alone"; "nowhere".
std::string span_text(const MeasuringInterval& span, PressureUnit unit);
std::string title_case(std::string text);

}  // namespace tactbench::analysis
