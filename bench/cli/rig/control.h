// Selects the live run to which RUN, --db and --bench on the command line refer; shared by the verbs that command or
// watch a run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/run/control/control_client.h"

namespace CLI {
class App;
}

namespace tactbench::bench {

struct Session;

struct LiveRunSelector {
  std::int64_t run = 0;  // 0: not named
  bool db_given = false;
  std::string bench;  // an id, or a bench file; empty: any
};

// The live runs of this machine that match the selection.
struct Candidates {
  std::vector<LiveRun> runs, others;  // runs that answer: selected; not selected
  std::vector<SilentBench> silent;    // benches that do not answer and could be selected
};

// Queries all live runs; waits at most 2 s.
Candidates candidates(const LiveRunSelector& named, const Session& session);
// The single matching run, for `verb`. `urgent`: also when other benches that could match do not answer. Throws Error
// TB-RUN-AMBIGUOUS, TB-RUN-NOT-LIVE, TB-RUN-SILENT, TB-RUN-DENIED.
LiveRun require_single_run(const Candidates& found, const LiveRunSelector& named, const std::string& verb, bool urgent);
// Throws Error TB-RUN-SILENT or TB-RUN-DENIED for the first of them.
[[noreturn]] void refuse_silent(const std::vector<SilentBench>& silent);

bool same_store(const std::string& one, const std::string& other);
std::string bench_id_of(const std::string& bench);  // `bench`: a bench file, or the id itself. Throws FileError
std::string listed(const std::vector<LiveRun>& runs, const std::vector<SilentBench>& silent = {});

}  // namespace tactbench::bench
