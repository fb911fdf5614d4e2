// Proxy between clients and a Modbus TCP server that can cut off those that only read: a dead-man's connection, while
// the sequencer's continues; or the sequencer's.
#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace tactbench::tests {

class ModuleProxy {
 public:
  explicit ModuleProxy(int server_port) : server_port_(server_port), listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof(address);
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 16) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("the proxy finds no port");
    }
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~ModuleProxy() {
    stop_ = true;
    thread_.join();
    ::close(listener_);
  }
  ModuleProxy(const ModuleProxy&) = delete;
  ModuleProxy& operator=(const ModuleProxy&) = delete;

  [[nodiscard]] int port() const { return port_; }
  // From now on connections that have not written are closed, and no new one lasts.
  void cut_off(bool so) { cut_off_ = so; }
  // The other way round: those that have written so far are closed, and no new one lasts.
  void cut_writers_off() { cut_writers_ = true; }

 private:
  struct Pair {
    ~Pair() {
      ::close(client);
      if (server >= 0) ::close(server);
    }
    int client = -1, server = -1;
    bool writes = false, done = false;
  };
  static sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  void take_client() {
    auto pair = std::make_unique<Pair>();
    pair->client = ::accept(listener_, nullptr, nullptr);
    if (pair->client < 0 || cut_off_ || writers_cut_) return;
    pair->server = ::socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in address = loopback(server_port_);
    if (::connect(pair->server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) return;
    pairs_.push_back(std::move(pair));
  }
  // Of one side to the other.
  static void pass(Pair& pair, bool from_client) {
    static const std::set<int> kWriting = {5, 6, 15, 16, 22, 23};
    constexpr std::size_t kFunctionAt = 7;
    std::array<unsigned char, 4096> bytes{};
    const ssize_t got = ::recv(from_client ? pair.client : pair.server, bytes.data(), bytes.size(), 0);
    pair.done = got <= 0;
    if (pair.done) return;
    const auto size = static_cast<std::size_t>(got);
    if (from_client && size > kFunctionAt) pair.writes = pair.writes || kWriting.contains(bytes[kFunctionAt]);
    (void)!::send(from_client ? pair.server : pair.client, bytes.data(), size, MSG_NOSIGNAL);
  }
  void serve() {
    constexpr int kTurnMs = 10;
    while (!stop_) {
      std::vector<pollfd> ready{{listener_, POLLIN, 0}};
      for (const auto& pair : pairs_) {
        ready.push_back({pair->client, POLLIN, 0});
        ready.push_back({pair->server, POLLIN, 0});
      }
      const std::size_t known = pairs_.size();
      (void)::poll(ready.data(), ready.size(), kTurnMs);
      if (ready[0].revents != 0) take_client();
      for (std::size_t i = 0; i < known; ++i) {
        Pair& pair = *pairs_[i];
        if (ready[1 + 2 * i].revents != 0) pass(pair, true);
        if (!pair.done && ready[2 + 2 * i].revents != 0) pass(pair, false);
      }
      const bool cut_writers = cut_writers_ && !writers_cut_;
      writers_cut_ = writers_cut_ || cut_writers;
      std::erase_if(pairs_, [&](const auto& pair) {
        return pair->done || (cut_off_ && !pair->writes) || (cut_writers && pair->writes);
      });
    }
  }

  int server_port_, listener_, port_ = 0;
  std::vector<std::unique_ptr<Pair>> pairs_;
  std::atomic<bool> stop_{false}, cut_off_{false}, cut_writers_{false};
  bool writers_cut_ = false;
  std::thread thread_;
};

}  // namespace tactbench::tests
