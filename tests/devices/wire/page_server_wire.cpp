// The page of a simulated instrument, request by request, served by this thread.
#include "devices/wire/ends/page_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <memory>
#include <string>
#include <vector>

#include "devices/wire/stream_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

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

TEST_CASE("page of an instrument: its own path, with a query or without, and no other") {
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

TEST_CASE("page of an instrument: a request in pieces is one request, one that does not end is dropped") {
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

TEST_CASE("page of an instrument: eight wait, a ninth takes the place of the first, who goes is forgotten") {
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

TEST_CASE("page of an instrument: its port is told where it is taken, and nothing stays open at its end") {
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
