// Reads the samples that a command-line argument names: a run of the store, or a table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/report/gather.h"
#include "bench/cli/session.h"
#include "bench/common/private_files.h"
#include "db/fleet/runs.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct TableOptions {
  std::string map, input_unit, output_unit;
  bool no_header = false;
  std::size_t skip_lines = 0;
  double noise = -1.0;  // standard deviation of the outputs; negative: estimated
  double turn =
      -1.0;  // an input that goes back by more than this has turned; negative: estimated from the noise of the inputs
  bool skip_bad_rows = false;
  bool timed = false;  // no option: HistoriesOptions::timed
};
// How a table is read: --map, --no-header, --skip-lines; predict and compensate have only these.
void add_layout_options(CLI::App& verb, TableOptions& options);
void add_table_options(CLI::App& verb, TableOptions& options);
// Throws AnalysisError TB-TABLE-MAP.
analysis::TableLayout layout_of(const TableOptions& options);

// "1-400,412" as ranges; empty: the text is not a list of runs.
struct RunRange {
  std::int64_t first = 0, last = 0;
  [[nodiscard]] bool holds(std::int64_t run) const { return run >= first && run <= last; }
};
std::vector<RunRange> run_ranges(const std::string& text);

// "12" is a run of session.db, anything else the path of a table.
bool is_run_number(const std::string& source);
// A run, measured or imported from a table; `at` names it in messages. `fitted`: the sequences that models will be
// fitted on; empty: all. Doubts about a table are printed on standard error. Throws AnalysisError, StoreError, Error
// TB-RUN-VOID.
analysis::Histories read_run(analysis::Runs& runs, std::int64_t run, const std::string& at, const TableOptions& table,
                             const Session& session, const std::vector<std::string>& fitted = {});
// For a table, assumptions made in reading it and rows left out are printed on standard error, too.
// Throws as read_run() and AnalysisError TB-TABLE-*.
analysis::Histories read_source(const std::string& source, const TableOptions& table, const Session& session,
                                const std::vector<std::string>& fitted = {});

// MODEL of the command line: a path, or RUN or RUN:FIT of session.db. Throws AnalysisError, StoreError, Error
// TB-RUN-VOID.
analysis::SensorModel load_model(const std::string& model, const Session& session);

// Checks the run of MODEL given as RUN or RUN:FIT by the rules of bench/reporting/evidence.h; a path is not checked.
void check_model_named(analysis::Runs& runs, const std::string& model, const std::string& at, const Session& session);

// "a,b" as a list; empty text: empty.
std::vector<std::string> split_list(const std::string& text);

// Makes runs of the fleet available to a verb that reads a store: copies them into a temporary store for the verb to
// read.

// The option --from of a verb that reads runs.
void add_from_option(CLI::App& verb, std::string& from);

// "12" as a number. Throws Error TB-USAGE.
std::int64_t run_number(const std::string& text);

class FleetImport {
 public:
  // `given`: connection string; "fleet" and "": the one in TACTBENCH_FLEET or tactbench.toml, Error TB-USAGE if neither
  // has one. Throws FleetError: TB-FLEET-CONNECT, TB-FLEET-LOGIN, TB-FLEET-TLS, TB-FLEET-EMPTY, TB-FLEET-SCHEMA.
  FleetImport(Session& session, const std::string& given);
  ~FleetImport();
  FleetImport(const FleetImport&) = delete;
  FleetImport& operator=(const FleetImport&) = delete;

  [[nodiscard]] db::fleet::Link& link() { return link_; }
  // From here to the end of this object, session.db is a new temporary store with these runs under the fleet's numbers.
  // Each is compared with its hashes, by the code that verifies a bench's own runs. Throws TB-FLEET-CHANGED;
  // TB-FLEET-CONFLICT when one serial is registered with two types. `also`: runs that are added if they can be read;
  // the others are named on standard error and left out.
  void take(const std::vector<db::fleet::FleetRun>& runs, const std::vector<db::fleet::FleetRun>& also = {});

 private:
  void take_one(db::RunStore& store, const db::fleet::FleetRun& run);
  Session& session_;
  db::fleet::Link link_;
  ScratchFolder folder_;
  std::string db_before_;
};

}  // namespace tactbench::bench
