// The run's side of the commands: it listens on the name of its bench (bench/run/control/machine_name.h), which is also
// the bench's lock, so that the run that answers there is the one that has the bench. Served by a thread of its own: an
// answer never waits for an instrument, nor for another client. Clients without the right (bench/run/control/peer.h)
// are refused.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/control/control.h"
#include "bench/run/control/machine_name.h"

namespace tactbench::bench {

class ControlSocket {
 public:
  // `bench_name`: held by the caller, who outlives this. None: it takes one itself; that of a bench inside its own
  // process, which shares no rig, carries the process's number. `run` is told by a further name also while the process
  // stands still. Throws Error TB-BENCH-LOCKED, TB-BENCH-NAME.
  ControlSocket(const BenchConfig& bench, Control& control, std::int64_t run, const MachineName* bench_name = nullptr);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;
  [[nodiscard]] const std::string& name() const { return listener_.text(); }

 private:
  struct Client {
    int descriptor = -1;
    bool trusted = false;
    std::string who;
  };
  void serve();
  void accept_some();
  void make_room();
  [[nodiscard]] bool answer(const Client& client);  // false: nothing was asked yet
  Control& control_;
  std::string bench_;
  MachineName own_;  // where none was given
  const MachineName& listener_;
  std::optional<gid_t> group_;  // looked up once: where users live on a server that takes its time
  MachineName run_name_;
  int stop_ = -1;
  std::vector<Client> clients_;  // oldest first
  std::thread thread_;
};

}  // namespace tactbench::bench
