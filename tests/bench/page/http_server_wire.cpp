// The page's HTTP server to the byte: heads, bodies and ends of its answers, its limits at their edges, and streams. By
// raw sockets, to a handler that echoes the request.

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <catch2/catch.hpp>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bench/page/http/http_server.h"
#include "bench/page/http/message.h"
#include "tests/bench/page/served_page.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
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

TEST_CASE("http: if every connection has the highest rank, one more is closed, and a free place is reused") {
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

// The page over TLS: a certificate with its key serves, one with another's key is refused, and bytes that are no TLS
// get nothing. Certificates are made here.

namespace {

// A key, and a certificate that it has signed for itself, as files.
class MadeCertificate {
 public:
  explicit MadeCertificate(const TemporaryFolder& folder, const std::string& name)
      : certificate(folder.path(name + ".pem")), key(folder.path(name + ".key")) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> pair(EVP_EC_gen("P-256"), &EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> own(X509_new(), &X509_free);
    X509_gmtime_adj(X509_getm_notBefore(own.get()), -3600);
    X509_gmtime_adj(X509_getm_notAfter(own.get()), 3600);
    X509_set_pubkey(own.get(), pair.get());
    REQUIRE(X509_sign(own.get(), pair.get(), EVP_sha256()) > 0);
    const auto write = [](const std::string& path, const auto& put) {
      const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "w"), &std::fclose);
      REQUIRE(file);
      REQUIRE(put(file.get()) == 1);
    };
    write(certificate, [&](std::FILE* file) { return PEM_write_X509(file, own.get()); });
    write(key, [&](std::FILE* file) {
      return PEM_write_PrivateKey(file, pair.get(), nullptr, nullptr, 0, nullptr, nullptr);
    });
  }
  std::string certificate, key;
};

// The answer to a client over TLS of at most that version; empty: no handshake.
std::string asked_over_tls(std::uint16_t port, const std::string& request, int version = TLS1_3_VERSION) {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), TLS1_VERSION);
  SSL_CTX_set_max_proto_version(context.get(), version);
  const std::unique_ptr<SSL, decltype(&SSL_free)> talk(SSL_new(context.get()), &SSL_free);
  const RawClient client(port);
  SSL_set_fd(talk.get(), client.descriptor());
  if (SSL_connect(talk.get()) != 1) return {};
  SSL_write(talk.get(), request.data(), static_cast<int>(request.size()));
  std::string got;
  char bytes[4096];
  for (int size = 1; size > 0;) {
    size = SSL_read(talk.get(), bytes, sizeof bytes);
    if (size > 0) got.append(bytes, static_cast<std::size_t>(size));
  }
  return got;
}

}  // namespace

TEST_CASE("page over TLS: answers of any length by TLS 1.2 and 1.3, and no answer without TLS") {
  const TemporaryFolder folder;
  const MadeCertificate made(folder, "a");
  HttpOptions options;
  options.certificate = made.certificate;
  options.key = made.key;
  HttpServer server(options, [](const HttpRequest& request, const Reply& reply) {
    reply(text_response(200, request.path + " from " + request.from + std::string(50'000, 'x')));
  });
  std::thread thread([&] { server.run(); });
  const std::string get = "GET /a HTTP/1.1\r\nConnection: close\r\n\r\n";
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    const std::string answer = asked_over_tls(server.port(), get, version);
    CHECK_THAT(answer, Catch::StartsWith("HTTP/1.1 200 OK\r\n"));
    CHECK(body_of(answer) == "/a from 127.0.0.1" + std::string(50'000, 'x'));
  }
  CHECK(asked_over_tls(server.port(), get, TLS1_1_VERSION).empty());
  const MadeCertificate other(folder, "b");
  const auto error = refusal_by([&] { (void)tls_context(made.certificate, other.key); });
  REQUIRE(error);
  CHECK((error->id() == "TB-PAGE-CERTIFICATE" && error->where() == other.key));
  RawClient plain(server.port());
  REQUIRE(plain.send(get));
  CHECK(plain.read().find("HTTP") == std::string::npos);
  server.stop();
  thread.join();
}

// Requests that the page's server refuses, by raw sockets: the real server with a real store. access_rules.cpp has the
// rules.

namespace {

// A page over a store with one run.
class GuardedPage : public WordsPage {
 public:
  explicit GuardedPage(const std::function<void(bench::PageOptions&)>& change = {})
      : WordsPage([&](bench::PageOptions& page) {
          db::RunStore store = db::RunStore::open(page.db);
          (void)begin_example(store);
          page.http.request_timeout = std::chrono::milliseconds(1500);
          if (change) change(page);
        }) {}
  // The whole answer to one request; `fields`: lines of the head.
  [[nodiscard]] std::string ask(const std::string& line, const std::string& token, const std::string& fields = {},
                                const std::string& body = {}) const {
    RawClient client(server->port());
    const std::string length = body.empty() ? "" : fmt::format("Content-Length: {}\r\n", body.size());
    (void)client.send(head(line, token, "Connection: close\r\n" + fields + length) + body);
    return client.read();
  }
  [[nodiscard]] const std::string& reads() const { return server->access().read_token; }
  [[nodiscard]] const std::string& commands() const { return server->access().command_token; }
};

constexpr const char* kJson = "Content-Type: application/json\r\nX-Tactbench: 1\r\n";
constexpr const char* kPause = R"({"word":"pause","run":1})";

}  // namespace

TEST_CASE("page: reading needs the token of the link in a header, and a request from its own name and page") {
  const GuardedPage page;
  for (const std::string& token : {page.reads(), page.commands()})
    CHECK(status_of(page.ask("GET /runs", token, "Sec-Fetch-Site: same-origin\r\n")) == 200);
  struct Row {
    int status;
    std::string line, token, fields;
  };
  const std::string read = page.reads();
  const std::vector<Row> rows = {
      {401, "GET /runs", "", ""},
      {401, "GET /events", "", ""},
      {401, "GET /runs", "0123456789abcdef0123456789abcdef", ""},
      {401, "GET /runs", read, fmt::format("Authorization: Bearer {}\r\n", read)},  // twice
      {401, "GET /runs?token=" + read, "", ""},
      {403, "GET /runs", read, "Origin: http://evil.example\r\n"},
      {403, "GET /runs", read, "Origin: null\r\n"},
      {403, "GET /runs", read, "Sec-Fetch-Site: cross-site\r\n"},
      {405, "DELETE /runs", read, ""},
      {404, "GET /nothing", read, ""},
      {404, "GET /../../etc/passwd", read, ""},
      {404, "GET /%2e%2e/%2e%2e/etc/passwd", read, ""},
      {404, "GET /document/../runs.db", "", ""},
      {404, "GET /document/0123456789abcdef0123456789abcdef", "", ""},
  };
  for (const Row& row : rows) {
    INFO(row.line << row.fields);
    const std::string answer = page.ask(row.line, row.token, row.fields);
    CHECK(status_of(answer) == row.status);
    for (const std::string& secret : {read, page.commands(), std::string("S-1")})  // the sensor of the store
      CHECK(answer.find(secret) == std::string::npos);
  }
}

TEST_CASE("page: commanding needs the token of the operator, and a same-origin JSON request of the page") {
  const GuardedPage page;
  const auto commanded = [&](const std::string& token, const std::string& fields, const std::string& body) {
    return status_of(page.ask("POST /command", token, fields, body));
  };
  CHECK(commanded(page.commands(), kJson, kPause) == 200);
  CHECK(commanded("", kJson, kPause) == 401);
  CHECK(commanded(page.reads(), kJson, kPause) == 401);
  CHECK(commanded(page.commands(), "Content-Type: text/plain\r\n", kPause) == 415);
  CHECK(commanded(page.commands(), "Content-Type: application/json\r\n", kPause) == 403);
  CHECK(commanded(page.commands(), kJson + std::string("Origin: http://evil.example\r\n"), kPause) == 403);
  CHECK(status_of(page.ask("GET /command?word=panic", page.commands())) == 405);
  for (const std::string& none : {std::string("pause"), std::string(R"(["pause"])"), std::string(2000, '['),
                                  std::string(R"({"word":7,"run":"x"})"), std::string(R"({"word":"reboot","run":1})")})
    CHECK(commanded(page.commands(), kJson, none) == 400);
  const GuardedPage without([](bench::PageOptions& options) { options.operator_name.clear(); });
  CHECK(without.commands().empty());
  CHECK(status_of(without.ask("POST /command", "", std::string("Authorization: Bearer \r\n") + kJson, kPause)) == 401);
}

TEST_CASE("page: a missing body and slowly sent requests do not block other requests") {
  const GuardedPage page;
  RawClient announced(page.server->port());
  REQUIRE(announced.send(page.head("POST /command", "", "Content-Length: 1000000\r\n")));
  CHECK(status_of(announced.read(5000)) == 413);
  std::vector<std::unique_ptr<RawClient>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<RawClient>(page.server->port()));
    REQUIRE(slow.back()->send("GET /runs HTTP/1.1\r\nHost: "));
  }
  CHECK(status_of(page.ask("GET /runs", page.reads())) == 200);
  for (const auto& one : slow) CHECK(one->closed(20'000));  // after 1.5 s here; one that drips does not hold on
  RawClient drips(page.server->port());
  bool kept = true;
  for (int i = 0; i < 200 && kept; ++i) kept = drips.send("G") && !drips.closed(20);
  CHECK_FALSE(kept);
}

TEST_CASE("page: every answer has the security headers, and the page loads nothing from other sites") {
  const GuardedPage page;
  for (const char* path : {"/", "/page.js", "/nothing", "/runs"}) {
    INFO(path);
    const std::string answer = page.ask(fmt::format("GET {}", path), page.reads());
    for (const char* field :
         {"Content-Security-Policy: default-src 'none';", "frame-ancestors 'none'", "X-Content-Type-Options: nosniff",
          "Referrer-Policy: no-referrer", "Cache-Control: no-store", "Cross-Origin-Resource-Policy: same-origin"})
      CHECK_THAT(answer, Catch::Contains(field));
    CHECK_THAT(answer, !Catch::Contains("Access-Control-Allow") && !Catch::Contains("Set-Cookie") &&
                           !Catch::Contains("unsafe-"));
  }
  for (const char* file : {"/", "/page.css", "/page.js", "/link.js", "/draw.js", "/now.js", "/panels.js", "/seen.js",
                           "/store.js", "/icon.svg"}) {
    INFO(file);
    std::string body = body_of(page.ask(fmt::format("GET {}", file), ""));
    CHECK(body.size() > 200);
    const std::size_t names_svg = body.find("http://www.w3.org/2000/svg");  // a name, which nothing loads
    if (names_svg != std::string::npos) body.erase(names_svg, 26);
    CHECK_THAT(body, !Catch::Contains("http://") && !Catch::Contains("https://") && !Catch::Contains("innerHTML") &&
                         !Catch::Contains(" onclick=") && !Catch::Contains("eval("));
  }
}
