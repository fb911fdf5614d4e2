// Byte streams: addresses of every form, what refuses and how it is told, what is set on what was opened.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <numeric>
#include <thread>
#include <vector>

#include "devices/wire/ends/loopback.h"
#include "devices/wire/ends/pseudo_terminal.h"
#include "devices/wire/stream_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/full_queue.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

std::string opening(const std::string& address) {
  return fault_id_of([&] { (void)open_stream(address, kShort); });
}

}  // namespace

TEST_CASE("stream: each form of address that is wrong, and each opening that fails") {
  const FullQueue unheard;
  for (const std::string& address :
       {std::string("tcp:"), std::string("tcp:127.0.0.1"), std::string("tcp::5"), std::string("tcp:127.0.0.1:"),
        std::string("tcp:127.0.0.1:no such service"), std::string("/dev/pts/999999"), std::string("/dev/pts/../null"),
        std::string("unix:/nowhere/at/all"), "unix:" + std::string(200, 'x'),
        "tcp:127.0.0.1:" + std::to_string(unheard.port())}) {
    INFO(address);
    CHECK(opening(address) == "TB-SERIAL-OPEN");
  }
  for (const char* address : {"serial", "/dev/ttyS0", "/dev/null", "udp:127.0.0.1:5"}) {
    CHECK(opening(address) == "TB-SERIAL-OPEN");
    CHECK_FALSE(is_stream_address(address));
  }
  for (const char* address : {"/dev/pts/3", "tcp:x", "unix:x"}) CHECK(is_stream_address(address));
  const PseudoTerminal terminal;
  const auto holder = open_stream(terminal.path());
  CHECK(opening(terminal.path()) == "TB-SERIAL-BUSY");
}

TEST_CASE("stream: an opening that nobody answers ends after its time") {
  FullQueue queue;
  queue.fill();
  const std::string name = "tcp:127.0.0.1:" + std::to_string(queue.port());
  CHECK(opening(name) == "TB-SERIAL-OPEN");
}

TEST_CASE("stream: an IPv6 address stands in brackets") {
  const int listener = ::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  socklen_t size = sizeof address;
  if (listener < 0 || ::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) != 0) return;  // no IPv6 here
  REQUIRE(::listen(listener, 4) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const std::string port = std::to_string(ntohs(address.sin6_port));
  CHECK(opening("tcp:[::1]:" + port) == "none");
  CHECK(opening("tcp:::1:" + port) == "none");
  for (const char* host : {"[::1", "::1]", "x::1]", "[::1x", "[]", "[", "]"}) {
    CHECK(opening("tcp:" + std::string(host) + ":" + port) == "TB-SERIAL-OPEN");
  }
  ::close(listener);
}

TEST_CASE("stream: a pseudo-terminal is raw, for its reader and writer both") {
  const PseudoTerminal terminal;
  const auto check_raw = [](int descriptor) {
    termios settings{};
    REQUIRE(::tcgetattr(descriptor, &settings) == 0);
    CHECK((settings.c_lflag & (ECHO | ICANON | ISIG | IEXTEN)) == 0);
    CHECK((settings.c_oflag & OPOST) == 0);
    return settings;
  };
  check_raw(terminal.master());  // before any client
  const auto stream = open_stream(terminal.path());
  const termios settings = check_raw(stream->descriptor());
  CHECK((settings.c_cflag & CLOCAL) != 0);
  CHECK((settings.c_cflag & CREAD) != 0);
  CHECK(settings.c_cc[VMIN] == 1);
  CHECK(settings.c_cc[VTIME] == 0);
  CHECK(::fcntl(stream->descriptor(), F_GETFD) == FD_CLOEXEC);
  CHECK((::fcntl(stream->descriptor(), F_GETFL) & O_NONBLOCK) != 0);
  CHECK(::fcntl(terminal.master(), F_GETFD) == FD_CLOEXEC);
}

TEST_CASE("stream: what is closed, full or no stream is lost") {
  const std::array<std::uint8_t, 5> bytes{1, 2, 3, 4, 5};
  std::array<std::uint8_t, 8> into{};
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  const auto socket = adopt_stream(line[0], "the line");
  CHECK(socket->read(into, 0ns) == 0);
  CHECK(socket->read(into, 1ms) == 0);
  ::close(line[1]);
  const std::string lost = "TB-SERIAL-LOST";
  CHECK(fault_id_of([&] { (void)socket->read(into, kPatient); }) == lost);
  CHECK(fault_id_of([&] { socket->write(bytes); }) == lost);
  const auto full = adopt_stream(::open("/dev/full", O_RDWR | O_CLOEXEC), "a full disk");
  CHECK(fault_id_of([&] { full->write(bytes); }) == lost);
  const auto folder = adopt_stream(::open("/", O_RDONLY | O_CLOEXEC), "a folder");
  CHECK(fault_id_of([&] { (void)folder->read(into, 0ns); }) == lost);
}

TEST_CASE("stream: discarding ends at a sender that never stops") {
  const auto endless = adopt_stream(::open("/dev/zero", O_RDONLY | O_CLOEXEC), "endless");
  CHECK(endless->discard() == 1U << 20U);
}

TEST_CASE("stream: what is not taken in time is told by its number of bytes, a slow reader gets all of them") {
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  std::vector<std::uint8_t> many(1U << 20U);
  std::iota(many.begin(), many.end(), std::uint8_t{0});
  {
    const auto hurried = adopt_stream(::fcntl(line[0], F_DUPFD_CLOEXEC, 0), "the line", 2ms);
    const auto fault = whole_fault_of([&] { hurried->write(many); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-SERIAL-TIMEOUT");
    std::vector<std::uint8_t> taken(many.size());
    std::size_t count = 0;
    for (ssize_t got = 1; got > 0; count += static_cast<std::size_t>(std::max<ssize_t>(got, 0))) {
      got = ::recv(line[1], taken.data(), taken.size(), 0);
    }
    CHECK_THAT(fault->what(), Catch::Contains(" " + std::to_string(many.size() - count) + " "));
  }
  std::vector<std::uint8_t> read;
  std::thread reader([&] {
    std::array<std::uint8_t, 4096> some{};
    pollfd waited{line[1], POLLIN, 0};
    while (read.size() < many.size() && ::poll(&waited, 1, 20000) == 1) {
      const ssize_t got = ::recv(line[1], some.data(), some.size(), 0);
      if (got <= 0) break;
      read.insert(read.end(), some.begin(), some.begin() + got);
    }
  });
  const auto patient = adopt_stream(line[0], "the line", kPatient);
  CHECK(fault_id_of([&] { patient->write(many); }) == "none");
  reader.join();
  CHECK((read == many));
  ::close(line[1]);
}
