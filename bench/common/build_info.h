// Which build of the program this is. One source holds the values, so that a new commit recompiles only that source.
#pragma once

#include <string>

namespace tactbench::bench {

struct BuildInfo {
  std::string version;        // of the project, "0.1.0"
  std::string commit;         // of git, 12 digits, or "unknown"
  std::string date;           // of the commit, "2026-11-22"
  bool modified = false;      // the sources differed from the commit
  std::string build;          // build type and compiler, "Release, GNU 12.2.0"
  std::string source_folder;  // absolute path of the sources
};

const BuildInfo& build_info();
// "base", "avx2" or "avx512": recomputed results are promised to be equal bit for bit within one of these.
const char* processor_class();
std::string commit_text();  // "f2d3ce0bd123", or "f2d3ce0bd123, modified"

}  // namespace tactbench::bench
