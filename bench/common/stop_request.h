// Records Ctrl-C and termination signals, so that the sequencer can act at its next step. Only one object exists at a
// time, or one nested in the lifetime of another; then both see the same signals. The previous handlers are restored at
// its end.
#pragma once

#include <csignal>
#include <string>
#include <vector>

namespace tactbench::bench {

class StopRequest {
 public:
  // SIGINT, SIGTERM, SIGHUP (unless it is ignored, as under nohup), SIGQUIT, SIGUSR1, SIGUSR2, SIGPWR, SIGXCPU; timers,
  // SIGIO and real-time signals if nothing else in the process handles them.
  StopRequest();
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  // From now on signals no longer end the process, even after this object is destroyed: the exit code is already
  // decided, and it may have priority over a signal's. Holds until the next object is made.
  static void keep();
  [[nodiscard]] int signal() const;      // the first signal received; 0: none
  [[nodiscard]] int interrupts() const;  // number of Ctrl-C
  [[nodiscard]] int ending() const;      // the first signal other than SIGINT, which requests an immediate end; 0: none

 private:
  struct Old {
    int number = 0;
    struct sigaction action {};
  };
  std::vector<Old> old_;
};

// The signal in words: "a request to terminate", "Ctrl-C".
std::string signal_text(int number);

}  // namespace tactbench::bench
