// A page that is asked for: each answer that is none, and each of the times that run out.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "devices/wire/ends/loopback.h"
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
  TurnedClock clock;

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

TEST_CASE("HTTP page: what is asked") {
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

TEST_CASE("HTTP page: the body's length, where it stands and what is no length") {
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

TEST_CASE("HTTP page: an answer of known length ends before the connection does") {
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

TEST_CASE("HTTP page: another status, and what is no answer of HTTP, are faults") {
  CHECK(answered("HTTP/1.1 404 Not Found\r\n\r\nbody") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.1 201 Created\r\n\r\n") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.1  200\r\n\r\n") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.\r\n\r\n") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.0 200\r\n\r\nx") == "x");
  CHECK(answered("HTTP/2 200 OK\r\n\r\n") == "TB-HTTP-ANSWER");
  CHECK(answered("HTTP/1.1 200 OK\r\n") == "TB-HTTP-ANSWER");
  CHECK(answered("x") == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP page: as large as allowed, and one byte more") {
  const std::string head = "HTTP/1.0 200 OK\r\n\r\n";
  for (const std::size_t size : {100, 101}) {
    ScriptedPage page(head + std::string(size - head.size(), 'x'));
    CHECK(page.get(kPatient, 100) == (size == 100 ? std::string(100 - head.size(), 'x') : "TB-HTTP-ANSWER"));
  }
}

TEST_CASE("HTTP page: an answer in many pieces, and one that breaks off") {
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

TEST_CASE("HTTP page: each time that runs out is told by what is missing, and has passed on the clock") {
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
  TurnedClock clock;
  CHECK(fault_id_of([&] {
          (void)http_get({"127.0.0.1", deaf.port, "/" + std::string(std::size_t{1} << 24U, 'p'), kShort, 4096}, "test",
                         clock);
        }) == "TB-HTTP-TIMEOUT");
  CHECK(clock.now() == kShort);
  ::close(deaf.socket);
}

TEST_CASE("HTTP page: a server that goes in the midst of the request") {
  ScriptedPage page([](int socket) { (void)ScriptedPage::receive(socket); });
  const std::string said = page.get(kPatient, 4096, "/" + std::string(std::size_t{1} << 24U, 'p'));
  CHECK(said == "TB-HTTP-ANSWER");
}

TEST_CASE("HTTP page: a long request reaches a slow reader whole") {
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

TEST_CASE("HTTP page: no address in numbers, nobody who listens, nobody who answers") {
  TurnedClock clock;
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
