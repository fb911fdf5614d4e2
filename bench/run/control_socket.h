// The control socket of a live run (contract.md: $XDG_RUNTIME_DIR/tactbench/<bench id>.sock), served by a thread of its
// own so that an answer never waits for an instrument; and the client's side.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/config.h"
#include "bench/run/control.h"

namespace tactbench::bench {

class ControlSocket {
 public:
  // A bench inside its own process has no lock on its id: its socket carries the process's number too. Throws Error
  // TB-CONTROL-SOCKET.
  ControlSocket(const BenchConfig& bench, Control& control);
  ~ControlSocket();
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  void serve();
  void answer(int client);
  Control& control_;
  std::string path_;
  int listener_ = -1, stop_ = -1;
  std::thread thread_;
};

struct LiveRun {
  std::string socket, bench;
  RunStatus status;
  bool taken = false;  // of the word sent
  std::string text;    // the answer
};

// Sends `word` to the run behind `socket`; none: nobody serves it. Bounded by a second.
std::optional<LiveRun> send_word(const std::string& socket, Word word);
// All runs of this user that answer.
std::vector<LiveRun> live_runs();

}  // namespace tactbench::bench
