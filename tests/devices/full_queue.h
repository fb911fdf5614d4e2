// A TCP port on loopback that never accepts: bound, so that nobody else listens there, then listening with a full
// queue, so that no connection is answered.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <vector>

namespace tactbench::devices {

class FullQueue {
 public:
  FullQueue() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    REQUIRE(::bind(socket_, reinterpret_cast<const sockaddr*>(&address_), size) == 0);
    REQUIRE(::getsockname(socket_, reinterpret_cast<sockaddr*>(&address_), &size) == 0);
  }
  ~FullQueue() {
    for (const int each : waiting_) ::close(each);
    ::close(socket_);
  }
  FullQueue(const FullQueue&) = delete;
  FullQueue& operator=(const FullQueue&) = delete;
  [[nodiscard]] int port() const { return ntohs(address_.sin_port); }
  // Before, connections are refused.
  void fill() {
    REQUIRE(::listen(socket_, 0) == 0);
    for (int i = 0; i < 4; ++i) {
      waiting_.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
      ::connect(waiting_.back(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
    }
  }

 private:
  int socket_;
  sockaddr_in address_{};
  std::vector<int> waiting_;
};

}  // namespace tactbench::devices
