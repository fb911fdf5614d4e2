// Remembers Ctrl-C and the request to terminate, so that the sequencer can act at its next step. One object at a time;
// the old handlers come back with its end.
#pragma once

#include <csignal>

namespace tactbench::bench {

class StopRequest {
 public:
  StopRequest();
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  [[nodiscard]] int signal() const;      // the first that came: SIGINT, SIGTERM; 0: none
  [[nodiscard]] int interrupts() const;  // how often Ctrl-C
  [[nodiscard]] bool terminate() const;

 private:
  struct sigaction old_interrupt_ {};
  struct sigaction old_terminate_ {};
};

}  // namespace tactbench::bench
