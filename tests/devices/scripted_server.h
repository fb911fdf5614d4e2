// A TCP server on loopback that answers each Modbus request by a test's script: wrong answers, late answers, none.
// Stops by itself.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "devices/wire/ends/end_activity.h"

namespace tactbench::devices {

using Bytes = std::vector<std::uint8_t>;

class ScriptedServer {
 public:
  // Called on the server's thread with the number of the request (from 0), its connection and its bytes.
  using Script = std::function<void(int number, int socket, const Bytes& request)>;

  // No timeout runs while a script does (end_activity.h), unless it is one that never rests.
  explicit ScriptedServer(Script script, bool rests = true)
      : script_(std::move(script)), listener_(::socket(AF_INET, SOCK_STREAM, 0)), stop_(::eventfd(0, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 || ::listen(listener_, 8) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no listener on loopback");
    }
    port_ = ntohs(address.sin_port);
    if (!rests) work_.leave();
    thread_ = work_.thread([this] { serve(); });
  }
  ~ScriptedServer() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    for (const int socket : opened_) ::close(socket);
    ::close(listener_);
    ::close(stop_);
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;
  [[nodiscard]] int port() const { return port_; }

  static void send(int socket, const Bytes& bytes) { ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  // The right answer to a reading of registers.
  static Bytes answer(const Bytes& request, const std::vector<std::uint16_t>& values) {
    Bytes reply(request.begin(), request.begin() + 8);
    reply[4] = 0;
    reply[5] = static_cast<std::uint8_t>(3 + 2 * values.size());
    reply.push_back(static_cast<std::uint8_t>(2 * values.size()));
    for (const std::uint16_t value : values) {
      reply.push_back(static_cast<std::uint8_t>(value >> 8U));
      reply.push_back(static_cast<std::uint8_t>(value & 0xFFU));
    }
    return reply;
  }

 private:
  void serve() {
    std::vector<pollfd> watched{{stop_, POLLIN, 0}, {listener_, POLLIN, 0}};
    for (int number = 0;;) {
      if (work_.wait(watched) < 0) continue;
      if (watched[0].revents != 0) return;
      for (std::size_t i = 2; i < watched.size(); ++i) {
        if (watched[i].revents == 0) continue;
        Bytes request(512);
        const ssize_t got = ::recv(watched[i].fd, request.data(), request.size(), 0);
        request.resize(static_cast<std::size_t>(got > 0 ? got : 0));
        if (got > 0) script_(number++, watched[i].fd, request);
        // The descriptor stays open, so that a late answer can never land on a newer connection.
        if (got <= 0) watched[i].fd = -1;
      }
      if (watched[1].revents != 0) {
        opened_.push_back(::accept(listener_, nullptr, nullptr));
        watched.push_back({opened_.back(), POLLIN, 0});
      }
    }
  }

  Script script_;
  int listener_;
  int stop_;
  int port_ = 0;
  std::vector<int> opened_;
  EndActivity work_;
  std::thread thread_;
};

}  // namespace tactbench::devices
