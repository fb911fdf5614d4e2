// A client that sends arbitrary bytes and reads the response: for requests that no browser makes.
#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace tactbench::tests {

class RawClient {
 public:
  explicit RawClient(std::uint16_t port) : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(port);
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    open_ = ::connect(descriptor_, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  }
  ~RawClient() { ::close(descriptor_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool send(const std::string& bytes) const {
    return open_ && ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  // The text received within that time, until the server closes or the text contains `until`.
  std::string read(int longest_ms = 30'000, const std::string& until = {}) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::milliseconds(longest_ms);
    char bytes[65536];
    std::size_t from = 0;  // what lies before was searched
    while (until.empty() || got_.find(until, from) == std::string::npos) {
      from = got_.size() - std::min(got_.size(), until.size());
      pollfd ready{descriptor_, POLLIN, 0};
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count();
      if (left <= 0 || ::poll(&ready, 1, static_cast<int>(left)) != 1) break;
      const ssize_t size = ::recv(descriptor_, bytes, sizeof bytes, 0);
      if (size <= 0) break;
      got_.append(bytes, static_cast<std::size_t>(size));
    }
    return got_;
  }
  // True when the server has closed within that time.
  bool closed(int longest_ms) {
    char bytes[4096];
    for (;;) {
      pollfd ready{descriptor_, POLLIN, 0};
      if (::poll(&ready, 1, longest_ms) != 1) return false;
      if (::recv(descriptor_, bytes, sizeof bytes, 0) <= 0) return true;
    }
  }
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
  bool open_ = false;
  std::string got_;
};

inline int status_of(const std::string& answer) {
  return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}

inline std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? std::string() : answer.substr(end + 4);
}

}  // namespace tactbench::tests
