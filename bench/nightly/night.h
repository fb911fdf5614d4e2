// Carries out a nightly run: the scenarios of a suite, each in a separate process with its own store, several in
// parallel, reported in the suite's order. A scenario whose process dies is reported red; the others continue.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/nightly/suite.h"

namespace tactbench::bench {

class StopRequest;

struct NightOptions {
  int jobs = 2;
  double limit_s = 300.0;  // real time per scenario; after it the process is killed and the scenario is red
  bool stop_on_red = false;
  std::string stores;                    // folder for each scenario's store NAME.db and output NAME.log
  std::string program;                   // program that runs `nightly SUITE --only NAME --result FILE`; empty: this one
  const StopRequest* signals = nullptr;  // signals that end the night; null: none
  bool replace = false;                  // also replaces a NAME.log that no night wrote
};

// Calls `on_result` with each result as it comes in; scenarios that were not reached are missing. Ctrl-C and
// termination signals end all scenarios. Throws Error TB-NIGHTLY-STOPPED then, TB-NIGHTLY-SPAWN when no process can be
// started, TB-FILE-WRITE. Replaces stores and output of an earlier night; before it replaces anything it throws
// TB-FILE-STORE for a NAME.db that no night made and TB-FILE-EXISTS for such a NAME.log.
std::vector<ScenarioResult> carry_out_night(const Suite& suite, const NightOptions& options,
                                            const std::function<void(const std::vector<ScenarioResult>&)>& on_result);

// JUnit XML of the whole suite; scenarios missing from `results` are reported as errors.
std::string junit_xml(const Suite& suite, const std::vector<ScenarioResult>& results);
// The same for Prometheus's text collector.
std::string metrics_text(const Suite& suite, const std::vector<ScenarioResult>& results);

}  // namespace tactbench::bench
