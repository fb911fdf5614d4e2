// report verify: whether a file is a report that somebody signed, unchanged since.
#pragma once

#include <cstdint>
#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

// The line of a run's notes that keeps the hash of a file of a signed report, without its date.
std::string report_file_note(const std::string& number, const std::string& sha256);

// Keeps the hash of a file that was written, where report `number` is signed; what is no regular file is left out. A
// store that cannot be written is a warning.
void keep_file_of_signed(const std::string& path, const std::string& number, std::int64_t run, const Session& session);

// `named`: a file, or the number of a signed report, whose files beside the store are looked at. Sets session.code:
// pass where a file is unchanged and its run counts, criterion failed where something was changed or the run is void,
// inconclusive where that cannot be told. Throws Error TB-USAGE for what is neither, StoreError. With `root`
// (certificates in PEM), or where a file has a signature (FILE.p7s), also what became of that (signature.h); then a
// file goes without a store, too.
void verify_report(const std::string& named, const std::string& root, Session& session);

// The verbs list and verify of `report`.
void add_reports_list(CLI::App& report, Session& session);

}  // namespace tactbench::bench
