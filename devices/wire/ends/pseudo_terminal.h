// The simulated end of a serial line: a pseudo-terminal whose slave side a client opens like a port (stream_link.h).
#pragma once

#include <string>

namespace tactbench::devices {

class PseudoTerminal {
 public:
  // In raw mode from the start, so that nothing is echoed before a client configures it. Throws Fault TB-SIM-LISTEN.
  PseudoTerminal();
  ~PseudoTerminal() { close_both(); }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  // The instrument's side, non-blocking: poll, read and write it. It is not affected by clients that come and go,
  // because the slave is kept open here too. -1 after hang_up().
  [[nodiscard]] int master() const { return master_; }
  [[nodiscard]] const std::string& path() const { return path_; }  // what the client opens, "/dev/pts/N"
  // Simulates unplugging: a client that has it open gets Fault TB-SERIAL-LOST immediately, and a new one
  // TB-SERIAL-OPEN. The slave stays open, because otherwise the system could give the path to the terminal of another
  // program, and the client would open that. Do not call it while another thread uses master().
  void hang_up();

 private:
  void close_both();
  int master_ = -1;
  int slave_ = -1;
  std::string path_;
};

}  // namespace tactbench::devices
