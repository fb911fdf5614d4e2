// The run's side of the commands: a server that listens on the name of its bench (bench/run/control/locks.h).
// That name is also the bench's lock, so only the run that holds the bench can answer there. It has its own thread: an
// answer never waits for an instrument or for another client. Clients that may not command the run
// (bench/run/control/locks.h) are refused. A client that follows gets the newest status, at up to 20 Hz; statuses are
// skipped if it reads too slowly.
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
#include "bench/run/control/locks.h"

namespace tactbench::bench {

class ControlSocket {
 public:
  // `bench_name`: held by the caller, must outlive this. Null: takes a name itself; for a bench simulated in this
  // process, which shares no rig, the name contains the process id. A second name shows the number `run` even while the
  // process is stopped. Throws Error TB-BENCH-LOCKED, TB-BENCH-NAME, TB-SYSTEM-LIMIT.
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
    std::uint64_t news = 0;  // for a following client: number of the last status sent
    std::chrono::steady_clock::time_point sent{};
  };
  void serve();
  void accept_some();
  void make_room();
  [[nodiscard]] bool answer(Client& client);  // false: no request yet, or the client follows
  [[nodiscard]] std::string reply(const Client& client, const Control::Answer& answer) const;
  void begin_following(Client& client);
  void send_to_followers();
  Control& control_;
  std::string bench_;
  MachineName own_;  // used if none was given
  const MachineName& listener_;
  std::optional<gid_t> group_;  // looked up once, because a user database on a server may be slow
  MachineName run_name_;
  int stop_ = -1;
  int spare_ = -1;               // descriptor to close for a client when the process's limit of open files is reached
  std::vector<Client> clients_;  // oldest first
  std::thread thread_;
};

}  // namespace tactbench::bench
