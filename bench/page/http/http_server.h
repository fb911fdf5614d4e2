// A small HTTP server for a few viewers, on Boost.Beast: one thread, all resources bounded. It serves no files and
// knows no instruments. One function handles all requests; a response may become a stream of server-sent events, in
// which each viewer gets the newest event of each kind.
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
  std::string certificate, key;           // files in PEM; both or none: without them the connection is not encrypted
  std::size_t max_head_bytes = 8 * 1024;  // bytes; more: 431
  std::size_t max_body_bytes = 4 * 1024;  // more: 413
  std::size_t max_viewers = 32;           // streams; more: 503
  std::size_t max_connections = 96;       // beyond it the oldest connection of the lowest rank is closed
  std::chrono::milliseconds request_timeout{
      10'000};  // from the start to the last byte of a request, and between two requests
  std::chrono::milliseconds longest_write{30'000};  // a viewer that receives nothing for so long is dropped
};

inline constexpr int kNeverEvicted = 2;  // a connection of this rank is never closed to make room for another

class HttpServer {
 public:
  using Handler = std::function<void(const HttpRequest&, Reply)>;
  // Rank that a request gives to its connection, by the request's token: 0 for an unknown client, up to kNeverEvicted.
  using Rank = std::function<int(const HttpRequest&)>;
  // Listens from now on. Throws Error TB-PAGE-ADDRESS, TB-PAGE-CERTIFICATE.
  HttpServer(const HttpOptions& options, Handler handler, Rank rank = {});
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  void run();   // serves until stop()
  void stop();  // from any thread

  // All functions below: on the server's thread, or before run().
  // Sends one event to all viewers. A viewer that has not yet received an earlier event of this kind gets the newer one
  // instead.
  void publish(int kind, const SharedText& event);
  [[nodiscard]] std::size_t viewers() const;
  [[nodiscard]] std::uint64_t skipped() const;  // number of events replaced by newer ones, over all viewers
  void every(std::chrono::milliseconds period, std::function<void()> act);
  // Calls `act` whenever `descriptor` can be read, until the returned handle is destroyed, which must be before the
  // server is. The caller keeps the descriptor.
  [[nodiscard]] std::shared_ptr<void> watch(int descriptor, std::function<void()> act);

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::bench
