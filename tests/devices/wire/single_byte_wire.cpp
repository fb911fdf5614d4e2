// The smallest thing that a wire carries, and its end, each with the error number that an earlier call has left.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <memory>
#include <string>

#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/fault_of.h"
#include "tests/support/process.h"

using namespace tactbench::devices;
using tactbench::tests::TemporaryFolder;
using namespace std::chrono_literals;

namespace {

using Some = std::array<std::uint8_t, 16>;
constexpr std::array<std::uint8_t, 1> kByte{7};
constexpr int kLeft[] = {0, EAGAIN, EINTR, EIO};  // errors of earlier calls

// The bytes that the end returns at its next event.
std::size_t received(StreamEnd& end, Some& into, int left) {
  pollfd waited{end.descriptor(), POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
  errno = left;
  return end.receive(into);
}

// Whether a client has gone: the next one is then waited for on another descriptor.
bool waits_for_a_client(const StreamEnd& end, int of_client) { return end.descriptor() != of_client; }

}  // namespace

TEST_CASE("stream listener: receives a single byte and detects a closed client, whatever errno was before") {
  for (const char* listen : {"tcp:0", "unix:"}) {
    const TemporaryFolder folder;
    StreamEnd end(listen == std::string("unix:") ? "unix:" + folder.path("end") : listen);
    for (const int left : kLeft) {
      INFO(listen << ", error " << left);
      Some some{};
      auto client = open_stream(end.address());
      CHECK(received(end, some, left) == 0);  // it came
      const int descriptor = end.descriptor();
      client->write(kByte);
      CHECK(received(end, some, left) == 1);
      CHECK(some[0] == 7);
      CHECK_FALSE(waits_for_a_client(end, descriptor));
      end.send(kByte);
      CHECK(client->read(some, 20s) == 1);
      client.reset();
      CHECK(received(end, some, left) == 0);
      CHECK(waits_for_a_client(end, descriptor));
    }
  }
}

TEST_CASE("stream: reads a single byte and reports the end of the connection, whatever errno was before") {
  for (const int left : kLeft) {
    INFO("error " << left);
    std::array<int, 2> line{};
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
    const auto stream = adopt_stream(line[0], "line");
    REQUIRE(::send(line[1], kByte.data(), 1, 0) == 1);
    Some some{};
    errno = left;
    CHECK(stream->read(some, 20s) == 1);
    ::close(line[1]);
    errno = left;
    CHECK(fault_id_of([&] { (void)stream->read(some, 20s); }) != "none");
  }
}

TEST_CASE("descriptor channel: receives a single byte and reports the end, whatever errno was before") {
  for (const int left : kLeft) {
    INFO("error " << left);
    const auto [a, b] = DescriptorChannel::make_pair();
    auto one = std::make_unique<DescriptorChannel>(a);
    DescriptorChannel other(b);
    CHECK(one->send("x"));
    errno = left;
    CHECK(other.receive(20s)->text == "x");
    one.reset();
    errno = left;
    CHECK_FALSE(other.receive(20s));
    CHECK(other.closed());
  }
}

TEST_CASE("UDP: a datagram of one byte is received, an empty one is not, and both are drained") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "test");
  UdpLink link("127.0.0.1", peer.port, "peer");
  link.send(kByte);
  Some some{};
  sockaddr_in client{};
  socklen_t length = sizeof client;
  REQUIRE(::recvfrom(peer.socket, some.data(), some.size(), 0, reinterpret_cast<sockaddr*>(&client), &length) == 1);
  const auto answer = [&](std::size_t bytes) {
    return ::sendto(peer.socket, some.data(), bytes, 0, reinterpret_cast<const sockaddr*>(&client), length);
  };
  for (const int left : kLeft) {
    INFO("error " << left);
    REQUIRE(answer(0) == 0);
    REQUIRE(answer(1) == 1);
    errno = left;
    CHECK(link.receive(some, 20s) == 1);
    CHECK(link.receive(some, 0ns) == 0);
    REQUIRE(answer(0) == 0);
    REQUIRE(answer(3) == 3);
    REQUIRE(answer(1) == 1);
    errno = left;
    CHECK(link.drain() == 3);
    CHECK(link.drain() == 0);
  }
  ::close(peer.socket);
}
