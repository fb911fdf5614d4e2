// Byte streams over a pseudo-terminal, TCP and a local socket; libserialport itself runs on a real port only.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <vector>

#include "devices/wire/ends/pseudo_terminal.h"
#include "devices/wire/serial_link.h"
#include "devices/wire/stream_link.h"
#include "tests/devices/fault_of.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Bytes = std::vector<std::uint8_t>;

SerialAddress at(const std::string& port, const std::string& usb_serial = "") {
  SerialAddress address;
  address.port = port;
  address.usb_serial = usb_serial;
  return address;
}

Bytes read_exactly(ByteStream& stream, std::size_t count) {
  Bytes all;
  std::array<std::uint8_t, 300> some{};
  while (all.size() < count) {
    const std::size_t got = stream.read(some, 5s);
    if (got == 0) break;
    all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(got));
  }
  return all;
}

Bytes read_exactly(int descriptor, std::size_t count) {
  Bytes all(count);
  std::size_t have = 0;
  while (have < count) {
    pollfd waited{descriptor, POLLIN, 0};
    if (::poll(&waited, 1, 5000) != 1) break;
    const ssize_t got = ::read(descriptor, all.data() + have, count - have);
    if (got <= 0) break;
    have += static_cast<std::size_t>(got);
  }
  all.resize(have);
  return all;
}

// Every value of a byte: none may be changed, swallowed or taken as a control character.
Bytes all_values() {
  Bytes bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

void check_both_ways(ByteStream& stream, int other_end) {
  stream.write(all_values());
  CHECK(read_exactly(other_end, 256) == all_values());
  const Bytes back = all_values();
  REQUIRE(::write(other_end, back.data(), back.size()) == 256);
  CHECK(read_exactly(stream, 256) == all_values());
  std::array<std::uint8_t, 8> nothing{};
  CHECK(stream.read(nothing, 0ns) == 0);
}

int accept_one(int listener) {
  pollfd waited{listener, POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 5000) == 1);
  return ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
}

}  // namespace

TEST_CASE("a pseudo-terminal carries every byte value unchanged both ways") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  check_both_ways(*stream, terminal.master());
  CHECK(stream->description() == terminal.path());
}

TEST_CASE("a pseudo-terminal has one client at a time and outlives it") {
  PseudoTerminal terminal;
  auto first = open_stream(terminal.path());
  CHECK(fault_id_of([&] { (void)open_stream(terminal.path()); }) == "TB-SERIAL-BUSY");
  first.reset();
  // What the first client left unread does not reach the second.
  const Bytes stale{1, 2, 3};
  REQUIRE(::write(terminal.master(), stale.data(), stale.size()) == 3);
  const auto second = open_stream(terminal.path());
  check_both_ways(*second, terminal.master());
}

TEST_CASE("discard drops unread bytes and returns their number") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  const Bytes waiting{1, 2, 3};
  REQUIRE(::write(terminal.master(), waiting.data(), waiting.size()) == 3);
  std::array<std::uint8_t, 1> first{};
  REQUIRE(stream->read(first, 5s) == 1);
  CHECK(stream->discard() == 2);
  CHECK(stream->discard() == 0);
}

TEST_CASE("a hung-up pseudo-terminal is a loss and not silence") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path());
  terminal.hang_up();
  std::array<std::uint8_t, 8> into{};
  const Bytes out{1};
  CHECK(fault_id_of([&] { (void)stream->read(into, 24h); }) == "TB-SERIAL-LOST");
  CHECK(fault_id_of([&] { stream->write(out); }) == "TB-SERIAL-LOST");
  CHECK(fault_id_of([&] { stream->discard(); }) == "TB-SERIAL-LOST");
  CHECK(terminal.master() == -1);
  const PseudoTerminal another;
  CHECK(another.path() != terminal.path());  // which another program's terminal might have, and the client would open
  CHECK(fault_id_of([&] { (void)open_stream(terminal.path()); }) == "TB-SERIAL-OPEN");
}

TEST_CASE("a writer is not blocked for ever by an end that reads nothing") {
  PseudoTerminal terminal;
  const auto stream = open_stream(terminal.path(), 1ms);
  const Bytes many(1U << 20U);
  CHECK(fault_id_of([&] { stream->write(many); }) == "TB-SERIAL-TIMEOUT");
}

TEST_CASE("a TCP stream carries bytes both ways and reports its end") {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(listener, 1) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  const std::string name = "tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  const auto stream = open_serial(at(name));
  const int other_end = accept_one(listener);
  check_both_ways(*stream, other_end);
  ::close(other_end);
  std::array<std::uint8_t, 8> into{};
  CHECK(fault_id_of([&] { (void)stream->read(into, 24h); }) == "TB-SERIAL-LOST");
  ::close(listener);
  CHECK(fault_id_of([&] { (void)open_stream(name); }) == "TB-SERIAL-OPEN");
}

TEST_CASE("a local socket carries bytes both ways and reports its end") {
  const auto path = std::filesystem::temp_directory_path() / ("tactbench-stream-" + std::to_string(::getpid()));
  std::filesystem::remove(path);
  const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  REQUIRE(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  REQUIRE(::listen(listener, 1) == 0);
  const auto stream = open_serial(at("unix:" + path.string()));
  const int other_end = accept_one(listener);
  check_both_ways(*stream, other_end);
  ::close(other_end);
  std::array<std::uint8_t, 8> into{};
  CHECK(fault_id_of([&] { (void)stream->read(into, 24h); }) == "TB-SERIAL-LOST");
  ::close(listener);
  std::filesystem::remove(path);
}

TEST_CASE("a serial address that leads to a pseudo-terminal is opened as one, links followed") {
  PseudoTerminal terminal;
  const auto link = std::filesystem::temp_directory_path() / ("tactbench-link-" + std::to_string(::getpid()));
  std::filesystem::remove(link);
  std::filesystem::create_symlink(terminal.path(), link);
  const auto stream = open_serial(at(link.string()));
  std::filesystem::remove(link);
  check_both_ways(*stream, terminal.master());
  CHECK(stream->description() == terminal.path());
}

TEST_CASE("listed serial ports have names and are never pseudo-terminals") {
  const PseudoTerminal terminal;
  for (const SerialPortInfo& port : list_serial_ports()) {
    CHECK(port.name.starts_with("/dev/"));
    CHECK(port.name != terminal.path());
  }
}
