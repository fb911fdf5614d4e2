// The page's server over a store with one run, queried by raw sockets, and a live run that only answers requests.
#pragma once

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "bench/page/page_server.h"
#include "db/run_store.h"
#include "tests/bench/page/raw_http.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

namespace tactbench::tests {

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
