// A report as a digital calibration certificate (DCC): XML by the schema of the Physikalisch-Technische Bundesanstalt,
// https://ptb.de/dcc, with quantities by D-SI. Pressures in kPa. Same input, same bytes.
// Each kind of history that U is valid for is a measurementResult of two results, increasing and decreasing pressure:
// the names of the taxels ("row,column" from 0), then a list a level of the reference value and, of all taxels, error,
// U and k, NaN where a taxel has none. What was judged follows, with limit and conformity.
#pragma once

#include <string>

#include "analysis/report/dcc/xml.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

// What a DCC must state and the report does not: "country, city of the laboratory file"; empty: nothing.
std::string dcc_lacks(const ReportInput& input);

// Of a report that lacks nothing.
std::string dcc_of(const PageData& data);

namespace dcc {
html::Markup measurement_results(const PageData& data);
// All that was judged, together: a statement.
html::Markup conformity_statement(const ReportInput& input);
}  // namespace dcc

}  // namespace tactbench::analysis
