// Protects signed reports from being overwritten.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "db/run_store.h"

namespace tactbench::bench {

// Of the files of a report: a page, a PDF, its data, a digital calibration certificate.
inline constexpr std::array kReportEndings = {"html", "pdf", "json", "xml"};

// Number of the signed report in the file; empty: no such file, or not a signed report. HTML and JSON are recognised by
// their data, whatever their names; other files by the numbers that were signed in this store.
std::string signed_report_in(const std::string& path, const db::RunStore& store);

// reports/NAME next to the store; reports/NUMBERED where NAME holds a signed report, or that of a run which is not the
// one with `uuid`: of another store in this folder.
std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid);

// Whether report `number` may be written to `path`: false when the file already holds this report, signed. Throws
// TB-REPORT-SIGNED when it holds another signed report.
bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store);

// Why the evidence of a signed report is no longer valid, one sentence each: a run that it is based on is void, or was
// changed in the store. `missing`: runs that this store does not have, so that they cannot be checked.
struct ReportEvidence {
  std::vector<std::string> fallen, missing;
};
ReportEvidence check_evidence(const db::RunStore& store, const db::ReportRecord& report);
// Of these the void runs alone, without reading any data.
std::vector<std::string> void_evidence(const db::RunStore& store, const db::ReportRecord& report);
// The signed reports that are based on a run, its own among them; without those that a later one replaced.
std::vector<db::ReportRecord> reports_based_on(const db::RunStore& store, std::int64_t run);

}  // namespace tactbench::bench
