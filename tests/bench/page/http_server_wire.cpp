// The page's HTTP server to the byte: heads, bodies and ends of its answers, its limits at their edges, and streams. By
// raw sockets, to a handler that echoes the request.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bench/page/http/http_server.h"
#include "tests/bench/page/raw_http.h"
#include "tests/support/endless_run.h"

using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

// "METHOD PATH name=value; field: value; body from ADDRESS"
std::string asked_text(const HttpRequest& request) {
  std::string text = request.method + " " + request.path;
  for (const auto& [name, value] : request.query) text += " " + name + "=" + value;
  for (const auto& [name, value] : request.fields) text += "; " + name + ": " + value;
  return text + "; " + request.body + " from " + request.from;
}

class AnsweringServer {
 public:
  // `set_up`: before it serves.
  explicit AnsweringServer(const HttpOptions& options = {}, const std::function<void(HttpServer&)>& set_up = {})
      : server_(
            options, [](const HttpRequest& request, const Reply& reply) { answer(request, reply); },
            [](const HttpRequest& request) { return std::atoi(request.field("rank").c_str()); }) {
    server_.every(milliseconds(5), [this] {
      viewers = server_.viewers();
      skipped = server_.skipped();
    });
    if (set_up) set_up(server_);
    thread_ = std::thread([this] { server_.run(); });
  }
  ~AnsweringServer() { stop(); }
  AnsweringServer(const AnsweringServer&) = delete;
  AnsweringServer& operator=(const AnsweringServer&) = delete;
  void stop() {
    if (!thread_.joinable()) return;
    server_.stop();
    thread_.join();
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  // All that comes until the server closes.
  [[nodiscard]] std::string ask(const std::string& bytes) const {
    RawClient client(port_);
    REQUIRE(client.send(bytes));
    return client.read();
  }
  std::atomic<std::size_t> viewers{0};
  std::atomic<std::uint64_t> skipped{0};

 private:
  static void answer(const HttpRequest& request, const Reply& reply) {
    if (request.path == "/none") return reply({.status = 404, .fields = {{"X-A", "b"}, {"X-C", "d"}}});
    if (request.path == "/stream")
      return reply({.type = "text/event-stream",
                    .body = std::make_shared<const std::string>("begun\n"),
                    .fields = {},
                    .stream = true});
    if (request.path == "/long") return reply(text_response(200, std::string(100'000, 'x')));
    reply(text_response(200, asked_text(request)));
  }
  HttpServer server_;
  std::uint16_t port_ = server_.port();
  std::thread thread_;
};

std::string whole_answer(const std::string& status, bool goes_on, const std::string& body,
                         const std::string& fields = {}) {
  return "HTTP/1.1 " + status +
         "\r\nContent-Type: text/plain; charset=utf-8\r\nConnection: " + (goes_on ? "keep-alive" : "close") +
         "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" + fields + "\r\n" + body;
}

HttpOptions small_limits() {
  HttpOptions options;
  options.max_head_bytes = 100;
  options.max_body_bytes = 10;
  return options;
}

// A request of so many bytes up to and with its empty line.
std::string head_of(std::size_t bytes) {
  const std::string begin = "GET / HTTP/1.1\r\nConnection: close\r\nX: ", end = "\r\n\r\n";
  return begin + std::string(bytes - begin.size() - end.size(), 'x') + end;
}

const std::string kStream = "GET /stream HTTP/1.1\r\nHost: x\r\n\r\n";

// A server that publishes an ever greater number, in events of 4 kB, a hundred times per second.
struct Flood {
  Flood()
      : server({}, [](const HttpRequest&, const Reply& reply) {
          reply({.type = "text/event-stream", .body = nullptr, .fields = {}, .stream = true});
        }) {
    server.every(milliseconds(10), [this] {
      const std::string number = std::to_string(++count);
      server.publish(0, std::make_shared<const std::string>("data: " + number + std::string(4096, ' ') + "\n\n"));
      if (count % 10 == 0) skipped = server.skipped();
    });
    thread = std::thread([this] { server.run(); });
  }
  ~Flood() {
    server.stop();
    thread.join();
  }
  int count = 0;
  std::atomic<std::uint64_t> skipped{0};
  HttpServer server;
  std::thread thread;
};

int last_number(const std::string& text) {
  const std::size_t at = text.rfind("data: ");
  return at == std::string::npos ? 0 : std::atoi(text.c_str() + at + 6);
}

}  // namespace

TEST_CASE("http: status, headers and body are exact, and all parts of a request are parsed") {
  const AnsweringServer server;
  CHECK(server.ask("GET /a?b=1&c=%20 HTTP/1.1\r\nHost: H\r\nConnection: close\r\nX-Two: one\r\nx-two: two\r\n\r\n") ==
        whole_answer("200 OK", false, "GET /a b=1 c= ; connection: close; host: H; x-two: one, two;  from 127.0.0.1"));
  CHECK(server.ask("POST /p HTTP/1.1\r\nConnection: close\r\nContent-Length: 4\r\n\r\nbody") ==
        whole_answer("200 OK", false, "POST /p; connection: close; content-length: 4; body from 127.0.0.1"));
  CHECK(server.ask("GET /none HTTP/1.0\r\n\r\n") == whole_answer("404 Not Found", false, "", "X-A: b\r\nX-C: d\r\n"));
  const std::string get = "GET / HTTP/1.1\r\n\r\n", last = "GET / HTTP/1.1\r\nConnection: close\r\n\r\n";
  const std::string first_answer = whole_answer("200 OK", true, "GET /;  from 127.0.0.1");
  CHECK(server.ask(get + get + last) ==
        first_answer + first_answer + whole_answer("200 OK", false, "GET /; connection: close;  from 127.0.0.1"));
  CHECK(body_of(server.ask("GET /long HTTP/1.1\r\nConnection: close\r\n\r\n")) == std::string(100'000, 'x'));
}

TEST_CASE("http: a request sent byte by byte is one request, and may be followed by the next") {
  const AnsweringServer server;
  RawClient client(server.port());
  for (const char byte : std::string("GET /x HTTP/1.1\r\n\r")) {
    REQUIRE(client.send(std::string(1, byte)));
    std::this_thread::sleep_for(milliseconds(1));
  }
  REQUIRE(client.send("\nGET /y HTTP/1.1\r\nConnection: close\r\n\r\n"));
  CHECK(client.read() == whole_answer("200 OK", true, "GET /x;  from 127.0.0.1") +
                             whole_answer("200 OK", false, "GET /y; connection: close;  from 127.0.0.1"));
}

TEST_CASE("http: too long and malformed requests are refused") {
  const AnsweringServer server(small_limits());
  CHECK_THAT(server.ask(head_of(90)), Catch::StartsWith("HTTP/1.1 200 OK\r\n"));
  CHECK(status_of(server.ask(head_of(400))) == 431);
  CHECK(status_of(server.ask("GET /" + std::string(200, 'x'))) == 431);  // without an end
  const auto post = [&](std::size_t bytes) {
    return server.ask("POST / HTTP/1.1\r\nConnection: close\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n" +
                      std::string(bytes, 'b'));
  };
  CHECK_THAT(post(10), Catch::EndsWith("bbbbbbbbbb from 127.0.0.1"));
  CHECK(status_of(post(11)) == 413);
  CHECK(status_of(server.ask("nonsense\r\n\r\n")) == 400);
  CHECK(status_of(server.ask("GET / HTTP/1.1\r\nno field\r\n\r\nGET / HTTP/1.1\r\n\r\n")) == 400);
}

TEST_CASE("http: a refused client may send on for a while, and still gets its answer") {
  const AnsweringServer server;
  RawClient client(server.port());
  REQUIRE(client.send("POST / HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n"));
  for (int i = 0; i < 50; ++i) REQUIRE(client.send(std::string(4000, 'b')));  // 200 kB of 256
  CHECK(status_of(client.read()) == 413);
  // It ends by itself a second later, or as soon as too much has come.
  RawClient waits(server.port()), floods(server.port());
  REQUIRE(waits.send("nonsense\r\n\r\n"));
  CHECK(status_of(waits.read()) == 400);
  REQUIRE(floods.send("nonsense\r\n\r\n"));
  CHECK(status_of(floods.read()) == 400);
  CHECK(comes_true([&] { return !waits.send("x"); }));
  bool refused = false;
  for (int i = 0; i < 5000 && !refused; ++i) refused = !floods.send(std::string(4000, 'b'));
  CHECK(refused);
}

TEST_CASE("http: a connection without a complete request is closed after a timeout that restarts at each answer") {
  HttpOptions options;
  options.request_timeout = milliseconds(700);
  const AnsweringServer server(options);
  RawClient silent(server.port()), begins(server.port()), idle(server.port());
  REQUIRE(begins.send("GET / HT"));
  REQUIRE(idle.send("GET / HTTP/1.1\r\n\r\n"));
  CHECK(silent.read().empty());
  CHECK(begins.read().empty());
  CHECK(idle.read() == whole_answer("200 OK", true, "GET /;  from 127.0.0.1"));
}

TEST_CASE("http: unauthenticated clients never displace authenticated ones, however many connect") {
  HttpOptions options;
  options.max_connections = 4;
  const AnsweringServer server(options);
  RawClient operates(server.port()), reads(server.port());
  const auto is_served = [](RawClient& client, const std::string& rank) {
    REQUIRE(client.send("GET /" + rank + " HTTP/1.1\r\nrank: " + rank + "\r\n\r\n"));
    return status_of(client.read(20'000, "127.0.0.1")) == 200;
  };
  REQUIRE((is_served(operates, "2") && is_served(reads, "1")));
  std::vector<std::unique_ptr<RawClient>> strangers;
  for (int i = 0; i < 50; ++i) strangers.push_back(std::make_unique<RawClient>(server.port()));
  RawClient late(server.port());
  CHECK(is_served(late, "2"));
  CHECK(strangers.front()->closed(20'000));
  CHECK_FALSE(strangers.back()->closed(100));
  for (RawClient* client : {&operates, &reads}) CHECK_FALSE(client->closed(100));
  CHECK(is_served(operates, "2"));
}

TEST_CASE("http: if all connections are privileged, a further one is closed, and a freed place is reused") {
  HttpOptions options;
  options.max_connections = 2;
  const AnsweringServer server(options);
  const std::string get = "GET / HTTP/1.1\r\nrank: 2\r\n\r\n";
  auto first = std::make_unique<RawClient>(server.port());
  RawClient second(server.port());
  for (RawClient* client : {first.get(), &second}) {
    REQUIRE(client->send(get));
    CHECK(status_of(client->read(20'000, "127.0.0.1")) == 200);
  }
  RawClient third(server.port());
  (void)third.send(get);
  CHECK(third.read().empty());
  first.reset();
  CHECK(comes_true([&] {
    RawClient again(server.port());
    (void)again.send(get);
    return status_of(again.read(20'000, "127.0.0.1")) == 200;
  }));
}

TEST_CASE("http: a stream has no content length, starts with its body, and continues with events") {
  HttpServer* publishes = nullptr;
  std::atomic<int> due{0};
  AnsweringServer server({}, [&](HttpServer& own) {
    publishes = &own;
    own.every(milliseconds(5), [&] {
      const int now = due.exchange(0);
      for (int i = 0; i < now; ++i) {
        publishes->publish(0, std::make_shared<const std::string>("a" + std::to_string(i) + ";"));
        publishes->publish(1, std::make_shared<const std::string>("b" + std::to_string(i) + ";"));
      }
    });
  });
  RawClient viewer(server.port()), other(server.port());
  REQUIRE(viewer.send(kStream));
  const std::string head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n\r\nbegun\n";
  CHECK(viewer.read(20'000, "begun\n") == head);
  REQUIRE(other.send("GET / HTTP/1.1\r\n\r\n"));
  CHECK(status_of(other.read(20'000, "127.0.0.1")) == 200);
  CHECK(comes_true([&] { return server.viewers == 1; }));
  due = 1;
  CHECK(viewer.read(20'000, "b0;") == head + "a0;b0;");
  CHECK(server.skipped == 0);
  // Three of each kind in one turn: the newest of each.
  due = 3;
  CHECK(viewer.read(20'000, "b2;") == head + "a0;b0;a2;b2;");
  CHECK(comes_true([&] { return server.skipped == 4; }));
  REQUIRE(viewer.send("what a viewer says is dropped"));
  due = 1;
  CHECK(viewer.read(20'000, "b2;a0;b0;") == head + "a0;b0;a2;b2;a0;b0;");
  CHECK(other.read(100, "never") == whole_answer("200 OK", true, "GET /;  from 127.0.0.1"));  // no viewer
  server.stop();
  CHECK(viewer.closed(20'000));
}

TEST_CASE("http: viewers above the limit are refused with the number of viewers, and a closed one is removed") {
  HttpOptions options;
  options.max_viewers = 1;
  AnsweringServer server(options);
  auto first = std::make_unique<RawClient>(server.port());
  REQUIRE(first->send(kStream));
  CHECK_THAT(first->read(20'000, "begun\n"), Catch::EndsWith("begun\n"));
  const std::string refused = server.ask(kStream + "GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
  CHECK(status_of(refused) == 503);
  CHECK_THAT(refused, Catch::Contains("\r\nRetry-After: 10\r\n") && Catch::Contains(" 1 ") &&
                          Catch::Contains("HTTP/1.1 200 OK\r\n"));
  CHECK(comes_true([&] { return server.viewers == 1; }));
  first.reset();
  CHECK(comes_true([&] { return server.viewers == 0; }));
}

TEST_CASE("http: a viewer that reads nothing for too long is dropped, an idle one without events is not") {
  HttpOptions options;
  options.longest_write = milliseconds(300);
  std::atomic<bool> flood{false};
  AnsweringServer server(options, [&](HttpServer& own) {
    own.every(milliseconds(5), [&own, &flood] {
      if (flood) own.publish(0, std::make_shared<const std::string>(65536, 'x'));
    });
  });
  RawClient stopped(server.port());
  REQUIRE(stopped.send(kStream));
  CHECK(comes_true([&] { return server.viewers == 1; }));
  std::this_thread::sleep_for(milliseconds(900));  // three times as long without news
  CHECK(server.viewers == 1);
  flood = true;
  CHECK(comes_true([&] { return server.viewers == 0; }));
}

TEST_CASE("page stream: events for a stopped viewer are replaced by newer ones, others get all") {
  Flood flood;
  const std::string get = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
  RawClient stopped(flood.server.port()), reader(flood.server.port());
  REQUIRE(stopped.send(get));
  REQUIRE(reader.send(get));
  std::string got;
  CHECK(comes_true([&] {
    got = reader.read(50, "never");
    return flood.skipped > 200;  // of the one that reads nothing
  }));
  const int newest = last_number(got);
  const std::string old = stopped.read(300, "never");  // what the kernel kept for it, and what fits in meanwhile
  CHECK(newest > 200);
  CHECK(old.size() < 3'000'000);
  CHECK(comes_true([&] { return last_number(stopped.read(20, "never")) > newest; }));  // it is up to date again
}
