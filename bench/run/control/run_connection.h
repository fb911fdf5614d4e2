// Non-blocking connection to one live run: requests are sent immediately, answers are polled. For a process with other
// work meanwhile (bench/page); control_client.h queries several runs and waits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bench/run/control/control_client.h"

namespace tactbench::bench {

class RunConnection {
 public:
  // Connects to the name of a bench and sends `words` (control_client.h). Not open if nobody listens on the name, or an
  // untrusted process (peer.h) that does not carry out a run of the store `db` (locks.h).
  RunConnection(std::string name, const std::string& words, const std::string& db = {});
  ~RunConnection();
  RunConnection(const RunConnection&) = delete;
  RunConnection& operator=(const RunConnection&) = delete;
  [[nodiscard]] bool open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // readable once data has arrived
  // The newest answer received; older ones are dropped. Once the run has closed its side, the connection is closed.
  std::optional<LiveRun> newest();

 private:
  void close();
  std::string name_;
  Peer server_;
  int descriptor_ = -1;
};

}  // namespace tactbench::bench
