// Where samples come from on the command line: a run of the store, or a table.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/report/runs.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

struct TableOptions {
  std::string map, input_unit, output_unit;
  double noise = -1.0;  // standard deviation of the outputs; negative: estimated
};
void add_table_options(CLI::App& verb, TableOptions& options);

// "12" is a run of session.db, anything else the path of a table.
bool names_run(const std::string& source);
// Throws AnalysisError, StoreError, Error TB-RUN-VOID.
analysis::Histories read_source(const std::string& source, const TableOptions& table, const Session& session);

// MODEL of the command line: a path, or RUN or RUN:FIT of session.db. Throws AnalysisError, StoreError, Error
// TB-RUN-VOID.
analysis::ModelDocument load_model(const std::string& model, const Session& session);

// The run of MODEL as RUN or RUN:FIT, by the rules of bench/reporting/named_runs.h; of a path nothing is asked.
void check_model_named(analysis::Runs& runs, const std::string& model, const std::string& at, const Session& session);

// "a,b" as a list; empty text: empty.
std::vector<std::string> split_list(const std::string& text);

}  // namespace tactbench::bench
