// Web page for monitoring a bench: an HTTP server in a process of its own. It reads the store, follows the live run
// through its control socket, and passes on the operator's commands; it holds no instrument and no lock.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "analysis/report/laboratory.h"
#include "bench/page/access.h"
#include "bench/page/http/http_server.h"

namespace tactbench::bench {

struct PageOptions {
  std::string db = "runs.db";
  std::string bench;          // id; empty: any whose run writes to the store
  std::string operator_name;  // empty: nobody may command
  std::string night;          // a page that `nightly --html` wrote; empty: none
  analysis::Laboratory laboratory;
  std::vector<std::string> names;  // further names of this server that a browser may use, without the port
  HttpOptions http;
  std::int64_t beside = 0;  // a process; 0: none. Once it has ended and nobody looks any more, serve() returns.
};

class PageServer {
 public:
  // Listens from now on. Throws Error TB-PAGE-ADDRESS, TB-PAGE-CERTIFICATE.
  explicit PageServer(const PageOptions& options);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  [[nodiscard]] const PageAccess& access() const;
  [[nodiscard]] std::uint16_t port() const;
  // With the tokens in their ends, which a browser does not send: for the operator, and for who only reads. One an
  // address, that of this machine first; where it listens on any address also those that other machines can type.
  [[nodiscard]] std::vector<std::string> links() const;
  [[nodiscard]] std::vector<std::string> readers_links() const;
  [[nodiscard]] std::string link() const { return links().front(); }
  [[nodiscard]] std::string readers_link() const { return readers_links().front(); }
  // Serves until `ended` returns true, asked a few times a second, or stop().
  void serve(const std::function<bool()>& ended);
  void stop();  // from any thread

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tactbench::bench
