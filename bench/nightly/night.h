// A night: the scenarios of a suite, each in a process and a store of its own, several at once, reported in the
// suite's order. A scenario whose process dies is red and says so; the others go on.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/nightly/scenario.h"

namespace tactbench::bench {

class StopRequest;

struct NightOptions {
  int jobs = 2;
  double limit_s = 300.0;  // real time a scenario: then its process is killed and it is red
  bool stop_on_red = false;
  std::string stores;                    // folder that keeps each scenario's store as NAME.db and its talk as NAME.log
  std::string program;                   // that carries out `nightly SUITE --only NAME --result FILE`; empty: this one
  const StopRequest* signals = nullptr;  // that end it; null: none is looked at
  bool replace = false;                  // a NAME.log that is no night's, too
};

// `on_result` is told of each result as it comes in. Scenarios that were not reached are missing at the end. Ctrl-C
// and a request to terminate end all that runs. Throws Error TB-NIGHTLY-STOPPED then, TB-NIGHTLY-SPAWN when no process
// can be started, TB-FILE-WRITE. Stores and talk of an earlier night are replaced; before anything is, TB-FILE-STORE
// for a NAME.db that no night made, TB-FILE-EXISTS for such a NAME.log.
std::vector<ScenarioResult> carry_out_night(const Suite& suite, const NightOptions& options,
                                            const std::function<void(const std::vector<ScenarioResult>&)>& on_result);

// JUnit XML of the whole suite; scenarios that `results` lacks are errors: they did not run.
std::string junit_xml(const Suite& suite, const std::vector<ScenarioResult>& results);
// The same for Prometheus's text collector.
std::string metrics_text(const Suite& suite, const std::vector<ScenarioResult>& results);

}  // namespace tactbench::bench
