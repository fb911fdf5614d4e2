// Viewers of the page's stream: each gets the newest, and one that is stopped costs bounded memory and delays nobody.
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <thread>

#include "bench/page/http/http_server.h"
#include "tests/bench/page/raw_http.h"
#include "tests/support/endless_run.h"

using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

// A server that publishes an ever greater number, in events of 4 kB, a hundred times a second.
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

TEST_CASE("page stream: a stopped viewer's news are replaced by newer ones, others get all") {
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
