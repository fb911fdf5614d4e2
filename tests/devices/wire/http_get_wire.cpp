#include "devices/wire/http_get.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <thread>

#include "devices/wire/ends/loopback.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// Answers each connection with `answer` and, unless it is to hold it, closes.
class RawPage {
 public:
  RawPage(std::string answer, bool hold) : bound_(bind_loopback(SOCK_STREAM, 0, "test")) {
    thread_ = std::thread([this, answer = std::move(answer), hold] {
      pollfd descriptor{bound_.socket, POLLIN, 0};
      ::poll(&descriptor, 1, 20'000);
      const int socket = ::accept(bound_.socket, nullptr, nullptr);
      std::array<char, 512> request{};
      [[maybe_unused]] const auto got = ::recv(socket, request.data(), request.size(), 0);
      [[maybe_unused]] const auto sent = ::send(socket, answer.data(), answer.size(), MSG_NOSIGNAL);
      if (hold) [[maybe_unused]]
        const auto end = ::recv(socket, request.data(), request.size(), 0);
      ::close(socket);
    });
  }
  ~RawPage() {
    thread_.join();
    ::close(bound_.socket);
  }
  [[nodiscard]] std::string get(Clock& clock, Nanoseconds timeout = 20s) const {
    return http_get({"127.0.0.1", bound_.port, "/p", timeout, 4096}, "test", clock);
  }

 private:
  BoundSocket bound_;
  std::thread thread_;
};

}  // namespace

TEST_CASE("HTTP page: ends with its length or with the connection, anything else is a fault") {
  TurnedClock clock;
  const std::string ok = "HTTP/1.1 200 OK\r\ncontent-length: 4\r\n\r\nbody";
  CHECK(RawPage(ok, true).get(clock) == "body");
  CHECK(RawPage("HTTP/1.0 200 OK\r\n\r\nto the end", false).get(clock) == "to the end");
  const auto complaint = [&](const std::string& answer) {
    const RawPage page(answer, false);
    const auto fault = fault_of([&] { (void)page.get(clock); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-HTTP-ANSWER");
    return std::string(fault->what());
  };
  CHECK_THAT(complaint("HTTP/1.0 200 OK\r\nContent-Length: 9\r\n\r\nbody"), Catch::Contains("4 of 9 bytes"));
  CHECK_THAT(complaint("SSH-2.0\r\n\r\n"), Catch::Contains("not an HTTP answer"));
  CHECK_THAT(complaint(""), Catch::Contains("0 bytes"));
  CHECK_THAT(complaint("HTTP/1.0 200 OK\r\n\r\n" + std::string(5000, 'x')), Catch::Contains("more than 4096"));
  CHECK(clock.now() == 0ns);
  const RawPage slow("HTTP/1.0 200 OK\r\nContent-Length: 9\r\n\r\nbody", true);
  CHECK(fault_id_of([&] { (void)slow.get(clock, 100ms); }) == "TB-HTTP-TIMEOUT");
  CHECK(clock.now() == 100ms);
}
