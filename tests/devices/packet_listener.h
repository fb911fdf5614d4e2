// The listening side of a packet link, at a path.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>

namespace tactbench::devices {

// A local socket of this type that is bound at the path.
inline int bound_at(const std::string& path, int type) {
  const int socket = ::socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  return socket;
}

class PacketListener {
 public:
  explicit PacketListener(const std::string& path) : socket_(bound_at(path, SOCK_SEQPACKET)) {
    REQUIRE(::listen(socket_, 8) == 0);
  }
  ~PacketListener() { close(); }
  PacketListener(const PacketListener&) = delete;
  PacketListener& operator=(const PacketListener&) = delete;
  [[nodiscard]] int accept() const {
    const int peer = ::accept(socket_, nullptr, nullptr);
    REQUIRE(peer >= 0);
    return peer;
  }
  void close() {
    if (socket_ >= 0) ::close(std::exchange(socket_, -1));
  }

 private:
  int socket_;
};

}  // namespace tactbench::devices
