// Remembers Ctrl-C and the requests to end, so that the sequencer can act at its next step. One object at a time; the
// old handlers come back with its end.
#pragma once

#include <array>
#include <csignal>
#include <string>

namespace tactbench::bench {

class StopRequest {
 public:
  // SIGINT, SIGTERM, SIGHUP (unless it is ignored, as under nohup), SIGQUIT, SIGUSR1, SIGUSR2.
  StopRequest();
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
  [[nodiscard]] int signal() const;      // the first that came; 0: none
  [[nodiscard]] int interrupts() const;  // how often Ctrl-C
  [[nodiscard]] int ending() const;      // the first but SIGINT, which asks for the end at once; 0: none

 private:
  struct Old {
    int number = 0;  // 0: not taken
    struct sigaction action {};
  };
  std::array<Old, 8> old_{};
};

// Who asks by that signal: "a request to terminate", "Ctrl-C".
std::string signal_text(int number);

}  // namespace tactbench::bench
