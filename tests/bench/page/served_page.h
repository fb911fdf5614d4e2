// The page's server over a store with one run, asked by raw sockets, and a run that answers as far as words go.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
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
  [[nodiscard]] nlohmann::json data_of(const std::string& path, int status = 200) const;
  [[nodiscard]] nlohmann::json command(const nlohmann::json& words) const;

  TemporaryFolder folder;
  bench::PageOptions options;
  std::unique_ptr<bench::PageServer> server;

 private:
  std::thread thread_;
};

}  // namespace tactbench::tests
