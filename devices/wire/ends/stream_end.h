// The instrument's end of a byte stream, for simulated instruments: a pseudo-terminal, or a listening socket with one
// client at a time. It can be unplugged and plugged in again. One thread only.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace tactbench::devices {

// The simulated end of a serial line: a pseudo-terminal whose slave side a client opens like a port (byte_stream.h).
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

class StreamEnd {
 public:
  // `listen`: "" a pseudo-terminal; "tcp:PORT" on loopback, 0 lets the system choose; "unix:PATH". Throws Fault
  // TB-SIM-LISTEN.
  explicit StreamEnd(std::string listen);
  ~StreamEnd() { hang_up(); }
  StreamEnd(const StreamEnd&) = delete;
  StreamEnd& operator=(const StreamEnd&) = delete;
  // The address for open_stream(). A pseudo-terminal has another one after plug_in().
  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] int descriptor() const;  // to be polled for reading; -1 while unplugged
  // Call when the descriptor is readable: returns bytes, or 0 if a client connected or disconnected. Never blocks.
  [[nodiscard]] std::size_t receive(std::span<std::uint8_t> into);
  // Never blocks: bytes that the client does not read are lost, as on a line without a listener.
  void send(std::span<const std::uint8_t> bytes);
  void hang_up();
  void plug_in();  // throws as the constructor

 private:
  void listen_tcp(int port);
  void listen_unix(const std::string& path);
  void listen_at(const void* address, std::size_t size);

  std::string listen_;
  std::string address_;
  std::unique_ptr<PseudoTerminal> terminal_;
  int listener_ = -1;
  int client_ = -1;
};

// A bound socket on 127.0.0.1 for a simulated end.
struct BoundSocket {
  int socket = -1;  // non-blocking; the caller closes it
  int port = 0;
};

// `type` is SOCK_STREAM (listening) or SOCK_DGRAM; port 0 lets the system choose. Throws Fault TB-SIM-LISTEN.
[[nodiscard]] BoundSocket bind_loopback(int type, int port, const std::string& device);

}  // namespace tactbench::devices
