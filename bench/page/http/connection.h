// One client's connection: requests one after the other, each with a deadline, or a stream of events.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/steady_timer.hpp>

#include "bench/page/http/http_server.h"
#include "bench/page/http/message.h"

namespace tactbench::bench {

// Data that all connections share.
struct ConnectionHost {
  HttpOptions options;
  HttpServer::Handler handler;
  HttpServer::Rank rank;
  std::size_t viewers = 0;
  std::uint64_t skipped = 0;
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(ConnectionHost& host, std::unique_ptr<Wire> wire, boost::asio::io_context& context);
  ~Connection();
  void start();
  void close();
  [[nodiscard]] int rank() const { return closed_ ? -1 : rank_; }
  void offer(int kind, const SharedText& event);  // to a viewer of the stream

 private:
  class Parser;
  void expect_request();
  void read_more();
  void take_bytes();
  void handle();
  void refuse(int status, const std::string& text);
  void answer(HttpResponse response, bool goes_on);
  void become_viewer();
  void part();
  void drop_the_rest();
  void watch_for_end();
  void write_events();
  void arm(std::chrono::milliseconds longest);

  ConnectionHost& host_;
  std::unique_ptr<Wire> wire_;
  boost::asio::steady_timer deadline_;
  std::array<char, 4096> bytes_{};
  std::string unread_;  // unparsed bytes of the request
  std::unique_ptr<Parser> parser_;
  std::string head_;
  SharedText body_;  // being sent
  bool closed_ = false, viewer_ = false, writing_ = false, due_ = false;
  std::size_t dropped_ = 0;
  int rank_ = 0;                                            // highest rank of its requests
  std::vector<std::pair<int, SharedText>> waiting_, sent_;  // at most one of each kind
};

}  // namespace tactbench::bench
