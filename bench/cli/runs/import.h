// Reads a table of samples from a file: its series and the hash of its bytes.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/table.h"
#include "bench/cli/runs/source.h"

namespace tactbench::bench {

inline constexpr const char* kTableRole = "table";  // an imported run's one device

struct TableFile {
  analysis::Table table;
  std::string sha256;
};
// Units from `options`, otherwise from the table's line of units. Throws AnalysisError TB-TABLE-*.
TableFile read_table_file(const std::string& path, const TableOptions& options);

// Options for reading the table's series. `fitted`: as for read_run().
analysis::HistoriesOptions options_of(const TableOptions& table, const std::vector<std::string>& fitted = {});

// Prints on standard error what was assumed in reading the table, and which rows were left out.
void print_table_assumptions(const std::string& path, const analysis::Table& table);
// Prints on standard error what is doubtful about the data.
void print_table_doubts(const analysis::Histories& histories);

}  // namespace tactbench::bench
