// Asked to stop by a signal (Ctrl-C, SIGTERM): the sequencer looks between two waits and ends the run through the
// safe state. A second signal changes nothing: there is no way out that does not vent.
#pragma once

#include <csignal>

namespace tactbench::bench {

class StopRequest {
 public:
  // Takes SIGINT and SIGTERM for as long as this object lives; one at a time.
  StopRequest();
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  // The signal's number, 0 for none.
  [[nodiscard]] int signal() const;

 private:
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace tactbench::bench
