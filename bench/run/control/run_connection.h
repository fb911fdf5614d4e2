// Non-blocking connection to one live run: requests are sent at once, answers are polled. For a process that serves
// others meanwhile (bench/page); control_client.h asks several runs and waits.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bench/run/control/control_client.h"

namespace tactbench::bench {

class RunConnection {
 public:
  // Connects to the name of a bench and sends `words` (control_client.h). Not open where nobody answers to the name, or
  // a stranger (peer.h) that carries out no run of the store `db` (locks.h).
  RunConnection(std::string name, const std::string& words, const std::string& db = {});
  ~RunConnection();
  RunConnection(const RunConnection&) = delete;
  RunConnection& operator=(const RunConnection&) = delete;
  [[nodiscard]] bool open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }  // readable once something has come
  // The newest answer that has come; older ones are dropped. Once the run has hung up the connection is closed.
  std::optional<LiveRun> newest();

 private:
  void close();
  std::string name_;
  Peer server_;
  int descriptor_ = -1;
};

}  // namespace tactbench::bench
