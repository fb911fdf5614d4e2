// The run's side of the commands: a server that listens on the name of its bench (bench/run/control/machine_name.h).
// That name is also the bench's lock, so only the run that holds the bench can answer there. It has its own thread: an
// answer never waits for an instrument or for another client. Clients without the right to command
// (bench/run/control/peer.h) are refused. A client that follows gets the newest status, at up to 20 Hz; statuses that
// it is too slow to read are skipped.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/control/control.h"
#include "bench/run/control/machine_name.h"
#include "bench/run/control/peer.h"

namespace tactbench::bench {

class ControlSocket {
 public:
  // `bench_name`: held by the caller, must outlive this. None: takes a name itself; for a bench simulated in this
  // process, which shares no rig, the name carries the process's number. A second name shows the number `run` even
  // while the process is stopped. Throws Error TB-BENCH-LOCKED, TB-BENCH-NAME,
  // TB-SYSTEM-LIMIT.
  ControlSocket(const BenchConfig& bench, Control& control, std::int64_t run, const MachineName* bench_name = nullptr);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;
  [[nodiscard]] const std::string& name() const { return listener_.text(); }

 private:
  struct Client {
    int descriptor = -1;
    bool trusted = false;
    std::optional<Peer> peer;
    bool follows = false;
    std::uint64_t news = 0;  // of a follower: as sent last
    std::chrono::steady_clock::time_point sent{};
  };
  void serve();
  void accept_some();
  void make_room();
  [[nodiscard]] bool answer(Client& client);  // false: nothing was asked yet, or it follows
  [[nodiscard]] std::string reply(const Client& client, const Control::Answer& answer) const;
  void begin_following(Client& client);
  void send_to_followers();
  Control& control_;
  std::string bench_;
  MachineName own_;  // where none was given
  const MachineName& listener_;
  std::optional<gid_t> group_;  // looked up once: slow where users are kept on a server
  MachineName run_name_;
  int stop_ = -1;
  int spare_ = -1;               // given up for a client when this process may open no more
  std::vector<Client> clients_;  // oldest first
  std::thread thread_;
};

}  // namespace tactbench::bench
