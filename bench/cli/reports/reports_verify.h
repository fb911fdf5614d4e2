// `report verify`: checks whether a file is a signed report and unchanged since it was signed.
#pragma once

#include <cstdint>
#include <string>

#include "bench/cli/session.h"

namespace tactbench::bench {

// The line in a run's notes that records the hash of a file of a signed report, without its date.
std::string report_file_note(const std::string& number, const std::string& sha256);

// Records the hash of a written file where report `number` is signed; a path that is not a regular file is skipped. A
// store that cannot be written is a warning.
void keep_file_of_signed(const std::string& path, const std::string& number, std::int64_t run, const Session& session);

// `named`: a file, or the number of a signed report, whose files next to the store are checked. Sets session.code: pass
// where a file is unchanged and its run counts, criterion failed where something was changed or the run is void,
// inconclusive where that cannot be determined. Throws Error TB-USAGE for what is neither, StoreError. With `root`
// (certificates in PEM), or where a file has a signature (FILE.p7s), also what became of that (signature.h); then a
// file goes without a store, too.
void verify_report(const std::string& named, const std::string& root, Session& session);

// The verbs list and verify of `report`.
void add_reports_list(CLI::App& report, Session& session);

}  // namespace tactbench::bench
