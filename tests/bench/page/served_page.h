// The page's server over a store with one run, queried by raw sockets, and a live run that only answers requests.
#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "bench/page/page_server.h"
#include "db/run_store.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// A client that sends arbitrary bytes and reads the response: for requests that no browser makes.

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

class WordsPage {
 public:
  explicit WordsPage(const std::function<void(bench::PageOptions&)>& change = {}) {
    options.db = folder.path("runs.db");
    options.operator_name = "bob";
    if (change) change(options);
    server = std::make_unique<bench::PageServer>(options);
    thread_ = std::thread([this] { server->serve([] { return false; }); });
  }
  ~WordsPage() { stop(); }
  WordsPage(const WordsPage&) = delete;
  WordsPage& operator=(const WordsPage&) = delete;
  void stop() {
    if (!thread_.joinable()) return;
    server->stop();
    thread_.join();
  }
  [[nodiscard]] std::string head(const std::string& line, const std::string& token,
                                 const std::string& more = {}) const {
    return fmt::format("{} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n{}{}\r\n", line, server->port(),
                       token.empty() ? "" : fmt::format("Authorization: Bearer {}\r\n", token), more);
  }
  [[nodiscard]] std::string get(const std::string& path) const {
    RawClient client(server->port());
    (void)client.send(head("GET " + path, server->access().read_token, "Connection: close\r\n"));
    return client.read();
  }
  [[nodiscard]] nlohmann::json data_of(const std::string& path, int status = 200) const {
    const std::string answer = get(path);
    INFO(path << ": " << answer);
    CHECK(status_of(answer) == status);
    return nlohmann::json::parse(body_of(answer));
  }
  [[nodiscard]] std::unique_ptr<RawClient> send_command(const nlohmann::json& words) const {
    const std::string body = words.dump();
    auto client = std::make_unique<RawClient>(server->port());
    REQUIRE(client->send(head("POST /command", server->access().command_token,
                              fmt::format("Connection: close\r\nContent-Type: application/json\r\nX-Tactbench: "
                                          "1\r\nContent-Length: {}\r\n",
                                          body.size())) +
                         body));
    return client;
  }
  [[nodiscard]] static nlohmann::json answer_to(RawClient& client) {
    const std::string answer = client.read();
    INFO(answer);
    CHECK(status_of(answer) == 200);
    return nlohmann::json::parse(body_of(answer));
  }
  [[nodiscard]] nlohmann::json command(const nlohmann::json& words) const { return answer_to(*send_command(words)); }

  TemporaryFolder folder;
  bench::PageOptions options;
  std::unique_ptr<bench::PageServer> server;

 private:
  std::thread thread_;
};

}  // namespace tactbench::tests
