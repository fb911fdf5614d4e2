// The live runs of this machine that this user may command.
#pragma once

#include <vector>

#include "bench/run/control/control_client.h"

namespace tactbench::tests {

inline std::vector<bench::LiveRun> live_runs() {
  std::vector<bench::LiveRun> answers = bench::send_to_runs(bench::run_names(), bench::Command::kStatus).answers;
  std::erase_if(answers, [](const bench::LiveRun& live) { return live.denied; });
  return answers;
}

}  // namespace tactbench::tests
