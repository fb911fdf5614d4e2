// No file with a signed report is written over.
#pragma once

#include <string>

#include "db/run_store.h"

namespace tactbench::bench {

// Number of the signed report that the file holds; empty: it is not there, or holds none. HTML and JSON tell it by
// their own data, whatever they are called; a PDF by the numbers that were signed in this store.
std::string signed_report_in(const std::string& path, const db::RunStore& store);

// Whether report `number` may be written to `path`: false where the file holds it signed already. Throws
// TB-REPORT-SIGNED where it holds another signed one.
bool may_be_written(const std::string& path, const std::string& number, const db::RunStore& store);

}  // namespace tactbench::bench
