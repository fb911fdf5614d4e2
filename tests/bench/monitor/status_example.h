// A run's status with every member filled, all with different values.
#pragma once

#include "bench/run/control/control_client.h"

namespace tactbench::tests {

inline bench::RunStatus example_status() {
  bench::RunStatus status;
  status.run = 7;
  status.state = bench::RunState::kPausing;
  status.store = "/data/runs.db";
  status.label = "run";
  status.reason = "asked by alice";
  status.question = "Point indenter mounted?";
  status.phase = "descending, step 19 of 217, repeat 2 of 5, unloading";
  status.step = 19;
  status.steps = 217;
  status.frames = 12;
  status.frames_planned = 211;
  status.left_s = 645.0;
  status.left_low_s = 630.0;
  status.left_high_s = 680.0;
  status.prompts_left = 1;
  status.rate = 10.0;
  status.target_n = 10.0;
  status.readings = bench::RunReadings{72.25, 40.0, 39.98, 40.01, true, 9.6};
  status.age_s = 0.25;
  return status;
}

inline bench::LiveRun example_live() {
  bench::LiveRun live;
  live.name = live.bench = "rig-1";
  live.server.process = 812;
  live.status = example_status();
  live.status.target_n.reset();
  live.taken = true;
  return live;
}

}  // namespace tactbench::tests
