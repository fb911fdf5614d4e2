// A page that is asked for: each answer that is none, and each of the times that run out.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "devices/wire/byte_stream.h"
#include "devices/wire/ends/page_server.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/http_get.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// One connection, given to a script in a thread.
class ScriptedPage {
 public:
  using Script = std::function<void(int socket)>;
  explicit ScriptedPage(Script script) : bound_(bind_loopback(SOCK_STREAM, 0, "test")) {
    thread_ = std::thread([this, script = std::move(script)] {
      pollfd descriptor{bound_.socket, POLLIN, 0};
      ::poll(&descriptor, 1, 20'000);
      const int socket = ::accept(bound_.socket, nullptr, nullptr);
      script(socket);
      ::close(socket);
    });
  }
  explicit ScriptedPage(const std::string& answer)
      : ScriptedPage([answer](int socket) {
          (void)receive(socket);
          send(socket, answer);
        }) {}
  ~ScriptedPage() {
    thread_.join();
    ::close(bound_.socket);
  }
  ScriptedPage(const ScriptedPage&) = delete;
  ScriptedPage& operator=(const ScriptedPage&) = delete;
  static std::string receive(int socket) {
    std::array<char, 512> request{};
    const ssize_t got = ::recv(socket, request.data(), request.size(), 0);
    return {request.data(), static_cast<std::size_t>(got > 0 ? got : 0)};
  }
  static bool send(int socket, const std::string& text) {
    return ::send(socket, text.data(), text.size(), MSG_NOSIGNAL) > 0;
  }
  [[nodiscard]] int port() const { return bound_.port; }
  // The body, or the fault's id.
  [[nodiscard]] std::string get(Nanoseconds timeout = kPatient, std::size_t largest = 4096,
                                const std::string& path = "/p") {
    try {
      return http_get({"127.0.0.1", port(), path, timeout, largest}, "test", clock);
    } catch (const Fault& fault) {
      CHECK(fault.device() == "test");
      return fault.id();
    }
  }
  ManualClock clock;

 private:
  BoundSocket bound_;
  std::thread thread_;
};

std::string answered(const std::string& answer) {
  ScriptedPage page(answer);
  const std::string result = page.get();
  CHECK(page.clock.now() == 0ns);
  return result;
}

}  // namespace

TEST_CASE("HTTP client: sends a GET request with the headers Host and Connection: close") {
  std::string asked;
  {
    ScriptedPage page([&](int socket) {
      asked = ScriptedPage::receive(socket);
      ScriptedPage::send(socket, "HTTP/1.0 200 OK\r\n\r\nbody");
    });
    CHECK(page.get() == "body");
  }
  CHECK(asked == "GET /p HTTP/1.0\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
}

TEST_CASE("HTTP client: uses the Content-Length header only, and a body shorter than it is a fault") {
  CHECK(answered("HTTP/1.0 200 OK\r\nContent-Length: 4\r\n\r\nbody") == "body");
  CHECK(answered("HTTP/1.0 200 OK\r\nA: b\r\nCONTENT-LENGTH:4\r\nC: d\r\n\r\nbody") == "body");
  CHECK(answered("HTTP/1.0 200 OK\r\ncontent-length:   0\r\n\r\n") == "");
  CHECK(answered("HTTP/1.0 200 OK\r\nContent-Length: 2\r\n\r\nbody") == "body");  // what came is given
  CHECK(answered("HTTP/1.0 200 OK\r\nContent-Length: many\r\n\r\nbody") == "body");
  CHECK(answered("HTTP/1.0 200 OK\r\nX-Content-Length: 9\r\n\r\nbody") == "body");
  CHECK(answered("HTTP/1.0 200 OK\r\nA: b\r\n\r\n\r\ncontent-length: 99\r\n") == "\r\ncontent-length: 99\r\n");
  CHECK(answered("HTTP/1.0 200 OK\r\nContent-Length: 5\r\n\r\nbody") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.0 200 OK\r\nContent-Length: 1\r\n\r\n") == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP client: an answer of known length ends before the connection closes") {
  for (const std::string body : {"", "b", "body"}) {
    ScriptedPage page([&](int socket) {
      (void)ScriptedPage::receive(socket);
      ScriptedPage::send(socket, "HTTP/1.0 200 OK\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n");
      if (!body.empty()) ScriptedPage::send(socket, body);
      (void)ScriptedPage::receive(socket);  // until the client closes
    });
    CHECK(page.get() == body);
  }
}

TEST_CASE("HTTP client: another status and an answer that is not HTTP are faults") {
  CHECK(answered("HTTP/1.0 200\r\n\r\nx") == "x");
  for (const char* other :
       {"HTTP/1.1 404 Not Found\r\n\r\nbody", "HTTP/1.1 201 Created\r\n\r\n", "HTTP/1.1  200\r\n\r\n",
        "HTTP/1.\r\n\r\n", "HTTP/2 200 OK\r\n\r\n", "HTTP/1.1 200 OK\r\n", "x"})
    CHECK(answered(other) == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP client: accepts an answer of the maximum size, and refuses one byte more") {
  const std::string head = "HTTP/1.0 200 OK\r\n\r\n";
  for (const std::size_t size : {100, 101}) {
    ScriptedPage page(head + std::string(size - head.size(), 'x'));
    CHECK(page.get(kPatient, 100) == (size == 100 ? std::string(100 - head.size(), 'x') : "TB-HTTP-ANSWER"));
  }
}

TEST_CASE("HTTP client: reads an answer in many pieces, and a broken connection is a fault") {
  const std::string text = "HTTP/1.0 200 OK\r\nContent-Length: 6\r\n\r\nbodies";
  ScriptedPage page([&](int socket) {
    (void)ScriptedPage::receive(socket);
    for (const char byte : text) {
      ScriptedPage::send(socket, std::string(1, byte));
      std::this_thread::sleep_for(1ms);
    }
  });
  CHECK(page.get() == "bodies");
  ScriptedPage reset([](int socket) {
    std::array<char, 8> some{};  // closed with the rest of the request unread
    (void)::recv(socket, some.data(), some.size(), 0);
  });
  CHECK(reset.get() == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP client: each timeout is a fault, and advances the clock by the timeout") {
  const auto out_of_time = [](ScriptedPage& page, const std::string& path = "/p") {
    const std::string said = page.get(kShort, std::size_t{1} << 30U, path);
    CHECK(page.clock.now() == kShort);
    return said;
  };
  const auto until_closed = [](int socket) {
    while (!ScriptedPage::receive(socket).empty()) {
    }
  };
  ScriptedPage silent(until_closed);
  CHECK(out_of_time(silent) == "TB-HTTP-TIMEOUT");
  ScriptedPage short_of_one([&](int socket) {
    (void)ScriptedPage::receive(socket);
    ScriptedPage::send(socket, "HTTP/1.0 200 OK\r\nContent-Length: 3\r\n\r\nab");
    until_closed(socket);
  });
  CHECK(out_of_time(short_of_one) == "TB-HTTP-TIMEOUT");
  ScriptedPage endless([](int socket) {
    (void)ScriptedPage::receive(socket);
    while (ScriptedPage::send(socket, std::string(64, 'x'))) std::this_thread::sleep_for(100us);
  });
  CHECK(out_of_time(endless) == "TB-HTTP-TIMEOUT");
  const BoundSocket deaf = bind_loopback(SOCK_STREAM, 0, "test");  // it takes connections, and reads nothing
  ManualClock clock;
  CHECK(fault_id_of([&] {
          (void)http_get({"127.0.0.1", deaf.port, "/" + std::string(std::size_t{1} << 24U, 'p'), kShort, 4096}, "test",
                         clock);
        }) == "TB-HTTP-TIMEOUT");
  CHECK(clock.now() == kShort);
  ::close(deaf.socket);
}

TEST_CASE("HTTP client: a server that closes during the request is a fault") {
  ScriptedPage page([](int socket) { (void)ScriptedPage::receive(socket); });
  const std::string said = page.get(kPatient, 4096, "/" + std::string(std::size_t{1} << 24U, 'p'));
  CHECK(said == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP client: a long request reaches a slow reader whole") {
  const std::string path = "/" + std::string(std::size_t{1} << 23U, 'p');
  std::size_t received = 0;
  {
    ScriptedPage page([&](int socket) {
      const std::size_t whole =
          path.size() + std::string("GET  HTTP/1.0\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n").size();
      while (received < whole) {
        const std::string some = ScriptedPage::receive(socket);
        if (some.empty()) break;
        received += some.size();
      }
      ScriptedPage::send(socket, received == whole ? "HTTP/1.0 200 OK\r\n\r\nwhole" : "HTTP/1.0 200 OK\r\n\r\npart");
    });
    CHECK(page.get(kPatient, 4096, path) == "whole");
  }
}

TEST_CASE("HTTP client: a host name, an invalid port and a port without a listener are faults") {
  ManualClock clock;
  const auto opening = [&](const std::string& host, int port, Nanoseconds timeout) {
    return fault_id_of([&] { (void)http_get({host, port, "/p", timeout, 4096}, "test", clock); });
  };
  CHECK(opening("localhost", 80, kPatient) == "TB-HTTP-OPEN");
  CHECK(opening("127.0.0.1", 0, kPatient) == "TB-HTTP-OPEN");
  const BoundSocket datagrams = bind_loopback(SOCK_DGRAM, 0, "test");
  CHECK(opening("127.0.0.1", datagrams.port, kPatient) == "TB-HTTP-OPEN");
  CHECK(clock.now() == 0ns);
  ::close(datagrams.socket);
}

// The page of a simulated instrument, request by request, served by this thread.

namespace {

void serve_once(PageServer& page) {
  std::vector<pollfd> descriptors;
  page.add_to(descriptors);
  REQUIRE(::poll(descriptors.data(), descriptors.size(), 20000) > 0);
  page.serve();
}

struct ServedPage {
  PageServer page{0, "/netftapi2.xml", "<body/>\n", "test"};

  [[nodiscard]] std::unique_ptr<ByteStream> client() {
    auto stream = open_stream("tcp:127.0.0.1:" + std::to_string(page.port()));
    serve_until([&, before = clients()] { return clients() > before || clients() == 8; });
    return stream;
  }
  [[nodiscard]] std::size_t clients() const {
    std::vector<pollfd> descriptors;
    page.add_to(descriptors);
    return descriptors.size() - 1;
  }
  template <class Done>
  void serve_until(Done&& done) {
    for (int events = 0; events < 1000 && !done(); ++events) serve_once(page);
    REQUIRE(done());
  }
  static void send(ByteStream& client, const std::string& text) {
    client.write(std::vector<std::uint8_t>(text.begin(), text.end()));
  }
  // All that comes until the server closes.
  static std::string rest(ByteStream& client) {
    std::string text;
    std::array<std::uint8_t, 256> some{};
    const auto fault = fault_of([&] {
      for (std::size_t got = client.read(some, kPatient); got > 0; got = client.read(some, kPatient)) {
        text.append(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(got));
      }
    });
    CHECK(fault);
    return text;
  }
  std::string answer_to(const std::string& request) {
    const auto asking = client();
    send(*asking, request);
    serve_until([&] { return clients() == 0; });
    return rest(*asking);
  }
};

const std::string kFound =
    "HTTP/1.0 200 OK\r\nContent-Type: text/xml\r\nContent-Length: 8\r\nConnection: close\r\n\r\n<body/>\n";
const std::string kNotFound =
    "HTTP/1.0 404 Not Found\r\nContent-Type: text/plain\r\nContent-Length: 13\r\nConnection: close\r\n\r\nno such "
    "page\n";

}  // namespace

TEST_CASE("page server: serves its own path, with or without a query, and no other") {
  ServedPage served;
  for (const char* line : {"GET /netftapi2.xml HTTP/1.0", "GET /netftapi2.xml HTTP/1.1\r\nHost: x",
                           "GET /netftapi2.xml", "GET /netftapi2.xml?index=0 HTTP/1.0", "GET /netftapi2.xml?"}) {
    INFO(line);
    CHECK(served.answer_to(line + std::string("\r\n\r\n")) == kFound);
  }
  for (const char* line :
       {"GET / HTTP/1.0", "GET /netftapi2.xmlx HTTP/1.0", "GET /netftapi2.xm HTTP/1.0", "POST /netftapi2.xml HTTP/1.0",
        "HEAD /netftapi2.xml HTTP/1.0", "x GET /netftapi2.xml", "", "?GET /netftapi2.xml"}) {
    INFO(line);
    CHECK(served.answer_to(line + std::string("\r\n\r\n")) == kNotFound);
  }
}

TEST_CASE("page server: accepts a request in pieces, and drops one that does not end") {
  ServedPage served;
  const auto client = served.client();
  std::array<std::uint8_t, 8> into{};
  for (const char* piece : {"G", "ET /netftapi2.xml HTT", "P/1.0\r\n", "\r"}) {
    ServedPage::send(*client, piece);
    serve_once(served.page);
    CHECK(served.clients() == 1);
    CHECK(client->read(into, 0ns) == 0);
  }
  ServedPage::send(*client, "\n");
  served.serve_until([&] { return served.clients() == 0; });
  CHECK(ServedPage::rest(*client) == kFound);
  for (const std::size_t size : {std::size_t{8191}, std::size_t{8192}}) {
    INFO(size << " bytes");
    const auto endless = served.client();
    for (std::size_t sent = 0; sent < size;) {  // no more at once than it reads at once
      const std::size_t part = std::min(size - sent, std::size_t{1024});
      ServedPage::send(*endless, std::string(part, 'x'));
      sent += part;
      serve_once(served.page);
    }
    CHECK(served.clients() == (size == 8191 ? 1 : 0));
    if (size == 8191) {
      ServedPage::send(*endless, "x");
      served.serve_until([&] { return served.clients() == 0; });
    }
  }
}

TEST_CASE("page server: eight clients may wait, a ninth replaces the first, and one that closes is removed") {
  ServedPage served;
  std::vector<std::unique_ptr<ByteStream>> clients;
  for (std::size_t i = 1; i <= 8; ++i) {
    clients.push_back(served.client());
    CHECK(served.clients() == i);
  }
  std::array<std::uint8_t, 8> into{};
  CHECK(clients[0]->read(into, 0ns) == 0);
  auto ninth = open_stream("tcp:127.0.0.1:" + std::to_string(served.page.port()));
  serve_once(served.page);
  CHECK(served.clients() == 8);
  CHECK(fault_id_of([&] { (void)clients[0]->read(into, kPatient); }) == "TB-SERIAL-LOST");
  CHECK(clients[1]->read(into, 0ns) == 0);
  for (auto* client : {&ninth, &clients[1], &clients[7]}) {
    ServedPage::send(**client, "GET /netftapi2.xml HTTP/1.0\r\n\r\n");
    served.serve_until([&, before = served.clients()] { return served.clients() < before; });
    CHECK(ServedPage::rest(**client) == kFound);
  }
  CHECK(served.clients() == 5);
  clients[2].reset();
  served.serve_until([&] { return served.clients() == 4; });
}

TEST_CASE("page server: a port in use is a fault that names it, and nothing stays open after its end") {
  auto page = std::make_unique<PageServer>(0, "/p", "body", "test");
  const int port = page->port();
  CHECK(port > 0);
  check_fault([&] { const PageServer other(port, "/p", "body", "instrument"); }, "TB-SIM-LISTEN", "instrument",
              std::to_string(port));
  for (const int none : {-1, 65536}) {
    CHECK(fault_id_of([&] { const PageServer other(none, "/p", "body", "instrument"); }) == "TB-SIM-LISTEN");
  }
  const auto client = open_stream("tcp:127.0.0.1:" + std::to_string(port));
  serve_once(*page);
  page.reset();
  std::array<std::uint8_t, 8> into{};
  CHECK(fault_id_of([&] { (void)client->read(into, kPatient); }) == "TB-SERIAL-LOST");
  CHECK(fault_id_of([&] { const PageServer again(port, "/p", "body", "test"); }) == "none");
}
