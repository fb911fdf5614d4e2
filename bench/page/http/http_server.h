// A small HTTP server for a few viewers, on Boost.Beast: one thread, everything bounded. It holds no file and knows no
// instrument. Requests are handed to one function; a response may become a stream of server-sent events, of which each
// viewer gets the newest of each kind.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "bench/page/http/message.h"

namespace tactbench::bench {

struct HttpOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;                 // 0: the system chooses
  std::string certificate, key;           // files in PEM; both or none: without them the talk is not encrypted
  std::size_t max_head_bytes = 8 * 1024;  // bytes; more: 431
  std::size_t max_body_bytes = 4 * 1024;  // more: 413
  std::size_t max_viewers = 32;           // streams; more: 503
  std::size_t max_connections = 96;       // then the oldest of the lowest rank makes room
  std::chrono::milliseconds request_timeout{10'000};  // from its first moment to its last byte, and between two
  std::chrono::milliseconds longest_write{30'000};    // a viewer that takes nothing for so long is dropped
};

inline constexpr int kNeverEvicted = 2;  // a connection of this rank never makes room for another

class HttpServer {
 public:
  using Handler = std::function<void(const HttpRequest&, Reply)>;
  // What a request's key makes its connection: 0, a stranger, as long as none has come, up to kNeverEvicted.
  using Rank = std::function<int(const HttpRequest&)>;
  // Listens from now on. Throws Error TB-PAGE-ADDRESS, TB-PAGE-CERTIFICATE.
  HttpServer(const HttpOptions& options, Handler handler, Rank rank = {});
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  void run();   // serves until stop()
  void stop();  // from any thread

  // All below on the server's thread, or before run().
  // One event to all viewers. A viewer that has not yet taken an earlier one of this kind gets the newer one instead.
  void publish(int kind, const SharedText& event);
  [[nodiscard]] std::size_t viewers() const;
  [[nodiscard]] std::uint64_t skipped() const;  // events that a newer one replaced, of all viewers
  void every(std::chrono::milliseconds period, std::function<void()> act);
  // Calls `act` whenever `descriptor`, which stays the caller's, can be read, until the handle is gone, which
  // must be before the server is.
  [[nodiscard]] std::shared_ptr<void> watch(int descriptor, std::function<void()> act);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::bench
