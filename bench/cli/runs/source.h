// Reads the samples that a command-line argument names: a run of the store, or a table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/report/runs.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

struct TableOptions {
  std::string map, input_unit, output_unit;
  bool no_header = false;
  std::size_t skip_lines = 0;
  double noise = -1.0;  // standard deviation of the outputs; negative: estimated
  double turn = -1.0;   // an input that goes back by more has turned; negative: by the inputs' own noise
  bool skip_bad_rows = false;
  bool timed = false;  // no option: HistoriesOptions::timed
};
// How its text is read: --map, --no-header, --skip-lines; all that predict and compensate take.
void add_layout_options(CLI::App& verb, TableOptions& options);
void add_table_options(CLI::App& verb, TableOptions& options);
// Throws AnalysisError TB-TABLE-MAP.
analysis::TableLayout layout_of(const TableOptions& options);

// "1-400,412" as ranges; empty: that is no list of runs.
struct RunRange {
  std::int64_t first = 0, last = 0;
  [[nodiscard]] bool holds(std::int64_t run) const { return run >= first && run <= last; }
};
std::vector<RunRange> run_ranges(const std::string& text);

// "12" is a run of session.db, anything else the path of a table.
bool names_run(const std::string& source);
// A run, measured or imported from a table; `at` names it in messages. `fitted`: the sequences that models will be
// fitted on; empty: all. What is doubtful about a table goes to standard error. Throws AnalysisError, StoreError, Error
// TB-RUN-VOID.
analysis::Histories read_run(analysis::Runs& runs, std::int64_t run, const std::string& at, const TableOptions& table,
                             const Session& session, const std::vector<std::string>& fitted = {});
// Of a table that is no run, what was assumed in reading it and which rows were left out goes to standard error, too.
// Throws as read_run() and AnalysisError TB-TABLE-*.
analysis::Histories read_source(const std::string& source, const TableOptions& table, const Session& session,
                                const std::vector<std::string>& fitted = {});

// MODEL of the command line: a path, or RUN or RUN:FIT of session.db. Throws AnalysisError, StoreError, Error
// TB-RUN-VOID.
analysis::SensorModel load_model(const std::string& model, const Session& session);

// Checks the run of MODEL given as RUN or RUN:FIT by the rules of bench/reporting/named_runs.h; a path is not checked.
void check_model_named(analysis::Runs& runs, const std::string& model, const std::string& at, const Session& session);

// "a,b" as a list; empty text: empty.
std::vector<std::string> split_list(const std::string& text);

}  // namespace tactbench::bench
