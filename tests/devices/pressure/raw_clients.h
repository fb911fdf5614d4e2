// Clients of a simulated module without Modbus: raw bytes out and in, over TCP or a serial line.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"

namespace tactbench::devices {

// A descriptor on which a simulated module answers; closed at its end.
class RawLine {
 public:
  using Bytes = std::vector<std::uint8_t>;
  explicit RawLine(int port) : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  explicit RawLine(const std::string& terminal) : descriptor_(::open(terminal.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    REQUIRE(descriptor_ >= 0);
  }
  ~RawLine() { hang_up(); }
  RawLine(const RawLine&) = delete;
  RawLine& operator=(const RawLine&) = delete;
  void hang_up() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }
  void send(const Bytes& bytes) const {
    REQUIRE(::write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  // `size` bytes, fewer at the end of the connection or where nothing comes any more.
  [[nodiscard]] Bytes receive(std::size_t size, int milliseconds = 20'000) const {
    Bytes bytes;
    pollfd waited{descriptor_, POLLIN, 0};
    while (bytes.size() < size && ::poll(&waited, 1, milliseconds) == 1) {
      Bytes some(size - bytes.size());
      const ssize_t got = ::read(descriptor_, some.data(), some.size());
      if (got <= 0) break;
      bytes.insert(bytes.end(), some.begin(), some.begin() + got);
    }
    return bytes;
  }
  // Whether the other side has closed, and sent nothing before.
  [[nodiscard]] bool is_closed() const {
    pollfd waited{descriptor_, POLLIN, 0};
    std::uint8_t byte = 0;
    return ::poll(&waited, 1, 20'000) == 1 && ::read(descriptor_, &byte, 1) <= 0;
  }
  // Whether nothing comes for a while; a short one, so that it may pass where something would come late.
  [[nodiscard]] bool is_silent() const { return receive(1, 50).empty(); }

 private:
  int descriptor_;
};

}  // namespace tactbench::devices
