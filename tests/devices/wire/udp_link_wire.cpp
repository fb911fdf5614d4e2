// UDP links: what they refuse and how it is told, and what renewing one means.
#include "devices/wire/udp_link.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "devices/wire/ends/loopback.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using UdpBytes = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("UDP: addresses that are none, and one that cannot be connected to") {
  for (const auto& [host, port] :
       {std::pair{"localhost", 5}, std::pair{"127.0.0.1", 0}, std::pair{"127.0.0.1", 65536}}) {
    CHECK(fault_id_of([&, host = host, port = port] { const UdpLink link(host, port, "box"); }) == "TB-UDP-OPEN");
  }
  CHECK(fault_id_of([] { const UdpLink link("255.255.255.255", 5, "box"); }) == "TB-UDP-OPEN");
}

TEST_CASE("UDP: nobody there, too much at once, and nothing in time") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "test");
  UdpLink link("127.0.0.1", peer.port, "box");
  CHECK(link.peer() == "127.0.0.1 port " + std::to_string(peer.port) + " (UDP)");
  UdpBytes into(8);
  for (const Nanoseconds timeout : {Nanoseconds(-1), Nanoseconds(0), Nanoseconds(1ms)}) {
    CHECK(link.receive(into, timeout) == 0);
  }
  CHECK(fault_id_of([&] { link.send(UdpBytes(70'000)); }) == "TB-UDP-LOST");
  const UdpBytes datagram{1, 2, 3};
  link.send(datagram);
  ::close(peer.socket);
  check_fault(
      [&] {
        link.send(datagram);
        (void)link.receive(into, kPatient);
      },
      "TB-UDP-LOST", "box");
  // An old error is drained, and does not spoil the next exchange.
  link.send(datagram);
  pollfd waited{-1, 0, 0};
  ::poll(&waited, 1, 1);
  CHECK(link.drain() <= 1);
  CHECK(link.drain() == 0);
}

TEST_CASE("UDP: renewed it has another port, and what was sent to the old one never arrives") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "test");
  UdpLink link("127.0.0.1", peer.port, "box");
  const auto asks = [&] {
    const UdpBytes datagram{1};
    link.send(datagram);
    pollfd waited{peer.socket, POLLIN, 0};
    REQUIRE(::poll(&waited, 1, 20000) == 1);
    sockaddr_in from{};
    socklen_t size = sizeof from;
    UdpBytes some(8);
    REQUIRE(::recvfrom(peer.socket, some.data(), some.size(), 0, reinterpret_cast<sockaddr*>(&from), &size) == 1);
    return from;
  };
  const auto answer = [&](const sockaddr_in& to, std::uint8_t byte) {
    return ::sendto(peer.socket, &byte, 1, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  };
  const sockaddr_in before = asks();
  link.renew();
  const sockaddr_in after = asks();
  CHECK(before.sin_port != after.sin_port);
  answer(before, 1);
  REQUIRE(answer(after, 2) == 1);
  UdpBytes into(8);
  CHECK(link.receive(into, kPatient) == 1);
  CHECK(into[0] == 2);
  const std::array<std::uint8_t, 4> four{1, 2, 3, 4};
  REQUIRE(::sendto(peer.socket, four.data(), 4, 0, reinterpret_cast<const sockaddr*>(&after), sizeof after) == 4);
  CHECK(link.receive(std::span(into).first(3), kPatient) == 3);  // cut to the room
  CHECK(link.receive(into, 0ns) == 0);
  ::close(peer.socket);
}
