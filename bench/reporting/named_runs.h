// Checks the runs that are named on the command line: which of them a verb may use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/report/runs.h"

namespace tactbench::bench {

struct RunsNamed {
  std::string at;                 // the option or place, for the error: "--held-out"
  std::int64_t models_of = 0;     // the models were made from this run, which is no independent data; 0: any run goes
  bool void_can_be_taken = true;  // --void-too is an option of the verb
};

// The runs as stored. Each must exist, be named once (TB-RUN-TWICE), not be the models' own (TB-RUN-OWN), and count: a
// void one is refused (TB-RUN-VOID), or, with `void_too` (--void-too), used with a warning on standard error.
std::vector<db::RunRecord> named_runs(analysis::Runs& runs, const std::vector<std::int64_t>& numbers,
                                      const RunsNamed& named, bool void_too);

}  // namespace tactbench::bench
