// A report as a digital calibration certificate (DCC): XML by the schema of the Physikalisch-Technische Bundesanstalt,
// https://ptb.de/dcc, with quantities by D-SI. Pressures in kPa. Same input, same bytes.
// Each kind of history for which U is valid is a measurementResult with two results, increasing and decreasing
// pressure: the names of the taxels ("row,column" from 0), then per level a list with the reference value and error, U
// and k of all taxels (NaN if a taxel has none). Judged figures follow, with limit and conformity.
#pragma once

#include <string>

#include "analysis/report/page/html.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

// Required statements of a DCC that the report lacks: "country, city of the laboratory file"; empty: none.
std::string dcc_lacks(const ReportInput& input);

// The DCC of a report for which dcc_lacks() is empty.
std::string dcc_of(const PageData& data);

}  // namespace tactbench::analysis
