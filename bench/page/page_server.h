// Web page for monitoring a bench: an HTTP server in a separate process. It reads the store, follows the live run
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
  std::string bench;          // id; empty: any bench whose run writes to the store
  std::string operator_name;  // empty: nobody may command
  std::string night;          // a page that `nightly --html` wrote; empty: none
  analysis::Laboratory laboratory;
  std::vector<std::string> names;  // further names of this server that a browser may use, without the port
  HttpOptions http;
  // A process; 0: none. serve() returns once that process has ended and nobody views the page any more.
  std::int64_t run_process = 0;
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
  // Links with the tokens in the fragment, which a browser does not send: for the operator, and for readers. One per
  // address, that of this machine first; if the server listens on all addresses, also those of the network interfaces.
  [[nodiscard]] std::vector<std::string> links() const;
  [[nodiscard]] std::vector<std::string> readers_links() const;
  [[nodiscard]] std::string link() const { return links().front(); }
  [[nodiscard]] std::string readers_link() const { return readers_links().front(); }
  // Serves until `ended` returns true, asked a few times per second, or stop().
  void serve(const std::function<bool()>& ended);
  void stop();  // from any thread

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tactbench::bench
