// The ends of simulated lines: what they listen on and what refuses that, their clients, and what they leave behind.
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "devices/wire/ends/stream_end.h"
#include "devices/wire/stream_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"
#include "tests/support/process.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::TemporaryFolder;

namespace {

std::string opening_end(const std::string& address) {
  return fault_id_of([&] { (void)open_stream(address, kShort); });
}

std::string listening(const std::string& listen) {
  return fault_id_of([&] { const StreamEnd end(listen); });
}

void next_event(const StreamEnd& end) {
  pollfd waited{end.descriptor(), POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
}

// A local socket's path of this length.
std::string long_path(const TemporaryFolder& folder, std::size_t length) {
  const std::string begin = folder.path("x");
  REQUIRE(begin.size() < length);
  return begin + std::string(length - begin.size(), 'y');
}

int option_of(int socket, int level, int name) {
  int value = -1;
  socklen_t size = sizeof value;
  CHECK(::getsockopt(socket, level, name, &value, &size) == 0);
  return value;
}

}  // namespace

TEST_CASE("stream end: what it listens on is told where that cannot be") {
  for (const char* port : {"", "x", "1x", " 1", "-1", "65536", "70000", "99999999999"})
    CHECK(listening("tcp:" + std::string(port)) == "TB-SIM-LISTEN");
  for (const char* form : {"udp:5", "/dev/ttyS0", "TCP:0", "x"}) CHECK(listening(form) == "TB-SIM-LISTEN");
  const StreamEnd end("tcp:0");
  CHECK(end.address().starts_with("tcp:127.0.0.1:"));
  const std::string taken = "tcp:" + end.address().substr(14);
  CHECK(listening(taken) == "TB-SIM-LISTEN");
}

TEST_CASE("stream end: the longest path of a local socket, on both its ends") {
  const TemporaryFolder folder;
  const std::string longest = "unix:" + long_path(folder, 107);
  StreamEnd end(longest);
  CHECK(end.address() == longest);
  CHECK(opening_end(longest) == "none");
  for (const std::string& address : {std::string("unix:"), "unix:" + long_path(folder, 108)}) {
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(opening_end(address) == "TB-SERIAL-OPEN");
  }
}

TEST_CASE("stream end: takes a dead program's socket over, and neither a living one's nor another file") {
  const TemporaryFolder folder;
  const std::string address = "unix:" + folder.path("end");
  {
    const StreamEnd living(address);
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(opening_end(address) == "none");
    errno = ECONNREFUSED;  // an older call's
    CHECK(listening(address) == "TB-SIM-LISTEN");
    // Its queue is full, and it lives.
    std::vector<std::unique_ptr<ByteStream>> clients;
    while (fault_id_of([&] { clients.push_back(open_stream(address, kShort)); }) == "none")
      REQUIRE(clients.size() < 99);
    CHECK(listening(address) == "TB-SIM-LISTEN");
    CHECK(std::filesystem::exists(folder.path("end")));
  }
  CHECK_FALSE(std::filesystem::exists(folder.path("end")));
  const int dead = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  const std::string path = folder.path("end");
  std::copy(path.begin(), path.end(), name.sun_path);
  REQUIRE(::bind(dead, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0);
  ::close(dead);
  REQUIRE(std::filesystem::exists(path));
  CHECK(listening(address) == "none");
  std::ofstream(path) << "notes";
  CHECK(listening(address) == "TB-SIM-LISTEN");
  CHECK(tactbench::tests::read_file(path) == "notes");
}

TEST_CASE("stream end: unplugged it has no descriptor, plugged in again the same address, a terminal another one") {
  const TemporaryFolder folder;
  for (const std::string& listen : {std::string("tcp:0"), "unix:" + folder.path("end"), std::string()}) {
    INFO("'" << listen << "'");
    StreamEnd end(listen);
    const std::string before = end.address();
    std::array<std::uint8_t, 8> into{};
    auto client = open_stream(before);
    end.hang_up();
    CHECK(end.descriptor() == -1);
    CHECK(fault_id_of([&] { (void)client->read(into, kPatient); }) == "TB-SERIAL-LOST");
    end.send(into);  // to nobody
    client.reset();
    end.plug_in();
    CHECK(end.descriptor() >= 0);
    if (!listen.empty()) CHECK(end.address() == before);
    client = open_stream(end.address());
    end.plug_in();  // plugged in twice: the first client is gone
    CHECK(fault_id_of([&] { (void)client->read(into, kPatient); }) == "TB-SERIAL-LOST");
    CHECK(opening_end(end.address()) == "none");
  }
}

TEST_CASE("stream end: one client at a time, and a second after it has gone") {
  StreamEnd end("tcp:0");
  std::array<std::uint8_t, 8> into{};
  CHECK(end.receive(into) == 0);  // nobody has come
  auto first = open_stream(end.address());
  next_event(end);
  CHECK(end.receive(into) == 0);
  CHECK(option_of(end.descriptor(), IPPROTO_TCP, TCP_NODELAY) == 1);
  CHECK(option_of(first->descriptor(), IPPROTO_TCP, TCP_NODELAY) == 1);
  CHECK(end.receive(into) == 0);  // it has sent nothing, and stays
  const auto second = open_stream(end.address());
  second->write(std::array<std::uint8_t, 2>{5, 6});
  first->write(std::array<std::uint8_t, 1>{4});
  next_event(end);
  CHECK(end.receive(into) == 1);
  CHECK(into[0] == 4);
  first.reset();
  next_event(end);
  CHECK(end.receive(into) == 0);
  next_event(end);
  CHECK(end.receive(into) == 0);
  next_event(end);
  CHECK(end.receive(into) == 2);
  end.send(std::array<std::uint8_t, 3>{7, 8, 9});
  CHECK(second->read(into, kPatient) == 3);
  const std::vector<std::uint8_t> many(1U << 23U);
  end.send(many);  // more than the socket takes: the rest is lost
}
