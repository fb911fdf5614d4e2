// Protects signed reports from being overwritten.
#pragma once

#include <string>

#include "db/run_store.h"

namespace tactbench::bench {

// Number of the signed report in the file; empty: no such file, or not a signed report. HTML and JSON are recognised by
// their data, whatever their names; a PDF by the numbers that were signed in this store.
std::string signed_report_in(const std::string& path, const db::RunStore& store);

// reports/NAME beside the store; reports/NUMBERED where NAME holds a signed report, or that of a run which is not the
// one with `uuid`: of another store in this folder.
std::string free_report_path(const db::RunStore& store, const std::string& name, const std::string& numbered,
                             const std::string& uuid);

// Whether report `number` may be written to `path`: false when the file already holds this report, signed. Throws
// TB-REPORT-SIGNED when it holds another signed report.
bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store);

}  // namespace tactbench::bench
