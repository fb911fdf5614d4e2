// Protects signed reports from being overwritten.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "db/run_store.h"

namespace tactbench::bench {

// File extensions of a report: page, PDF, data, digital calibration certificate.
inline constexpr std::array kReportEndings = {"html", "pdf", "json", "xml"};

// Number of the signed report in the file; empty: no such file, or not a signed report. HTML and JSON are recognised by
// their data, whatever their names; other files by the report numbers signed in this store.
std::string signed_report_in(const std::string& path, const db::RunStore& store);

// reports/NAME next to the store; reports/NUMBERED if NAME holds a signed report, or the report of a run with another
// UUID than `uuid`, from another store in this folder.
std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid);

// Whether report `number` may be written to `path`: false when the file already holds this report, signed. Throws
// TB-REPORT-SIGNED when it holds another signed report.
bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store);

// Why the evidence of a signed report is no longer valid, one sentence each: a run on which it is based is void, or was
// changed in the store. `missing`: runs that this store does not have, so they cannot be checked.
struct ReportEvidence {
  std::vector<std::string> fallen, missing;
};
ReportEvidence check_evidence(const db::RunStore& store, const db::ReportRecord& report);
// Only the sentences about void runs, without reading any data.
std::vector<std::string> void_evidence(const db::RunStore& store, const db::ReportRecord& report);
// The signed reports that are based on a run, its own among them; without reports that a later one replaced.
std::vector<db::ReportRecord> reports_based_on(const db::RunStore& store, std::int64_t run);

}  // namespace tactbench::bench
