// A table as a file: its series and the hash of its bytes.
#pragma once

#include <string>
#include <vector>

#include "analysis/table.h"
#include "bench/cli/runs/source.h"

namespace tactbench::bench {

inline constexpr const char* kTableRole = "table";  // an imported run's one device

struct TableFile {
  std::vector<analysis::TableSeries> series;
  std::string sha256;
};
// Throws AnalysisError TB-TABLE-*.
TableFile read_table_file(const std::string& path, const TableOptions& options);

}  // namespace tactbench::bench
