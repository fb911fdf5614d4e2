// The instrument's end of a byte stream, for simulated instruments: a pseudo-terminal, or a listening socket with one
// client at a time. It can be unplugged and plugged in again. One thread only.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "devices/wire/ends/pseudo_terminal.h"

namespace tactbench::devices {

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

}  // namespace tactbench::devices
