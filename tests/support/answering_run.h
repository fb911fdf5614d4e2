// Runs of this process that only answer requests, and runs that do not answer.
#pragma once

#include <memory>
#include <string>

#include "bench/run/control/control_socket.h"
#include "bench/run/control/locks.h"

namespace tactbench::tests {

// At step 3 of 40.
struct AnsweringRun {
  AnsweringRun(const std::string& bench, std::int64_t run, const std::string& store,
               bench::RunState state = bench::RunState::kRunning) {
    config.id = bench;
    status.run = run;
    status.store = store;
    status.state = state;
    status.step = 3;
    status.steps = 40;
    publish();
    socket = std::make_unique<bench::ControlSocket>(config, control, run);
  }
  void publish() { control.publish(status); }
  bench::BenchConfig config;
  bench::Control control;
  bench::RunStatus status;
  std::unique_ptr<bench::ControlSocket> socket;
};

// Of a process that was stopped: its names are held, and nobody answers. `run`: "/run/7".
struct SilentRun {
  SilentRun(const std::string& bench, const std::string& run) : name(bench), numbered(bench + run) {}
  bench::MachineName name, numbered;
};

}  // namespace tactbench::tests
