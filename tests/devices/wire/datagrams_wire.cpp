// Packet links and channels: what each refuses and how it is told, batches and sizes at their limits.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/report_link.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/timeouts.h"
#include "tests/support/process.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using namespace tactbench::tests;
using tactbench::tests::TemporaryFolder;

namespace {

using Datagram = std::vector<std::uint8_t>;

// The other side of a packet link.
struct PacketPeer {
  explicit PacketPeer(std::string at)
      : path(std::move(at)), listener(path), link(open_packet_link(path)), peer(listener.accept()) {}
  ~PacketPeer() { go(); }
  PacketPeer(const PacketPeer&) = delete;
  PacketPeer& operator=(const PacketPeer&) = delete;
  void go() {
    if (peer >= 0) ::close(std::exchange(peer, -1));
  }
  void send(const Datagram& packet) const {
    REQUIRE(::send(peer, packet.data(), packet.size(), 0) == static_cast<ssize_t>(packet.size()));
  }
  Datagram read(std::size_t room, Nanoseconds timeout = kPatient) const {
    Datagram into(room);
    into.resize(link->read(into, timeout));
    return into;
  }
  std::string path;
  PacketListener listener;
  std::unique_ptr<ReportLink> link;
  int peer;
};

}  // namespace

TEST_CASE("packet link: packets arrive in order, over several batches, whole or cut to the buffer") {
  const TemporaryFolder folder;
  const PacketPeer rig(folder.path("peer"));
  CHECK(rig.read(8, 0ns).empty());
  CHECK(rig.read(8, 1ms).empty());
  CHECK(rig.read(8, -1ms).empty());
  for (const int count : {1, 31, 32, 33, 70}) {
    for (int i = 0; i < count; ++i)
      rig.send(Datagram(static_cast<std::size_t>(i % 5 + 1), static_cast<std::uint8_t>(i)));
    for (int i = 0; i < count; ++i) {
      INFO(i << " of " << count);
      CHECK(rig.read(8) == Datagram(static_cast<std::size_t>(i % 5 + 1), static_cast<std::uint8_t>(i)));
    }
    CHECK(rig.read(8, 0ns).empty());
  }
  rig.send({1, 2, 3, 4});
  rig.send({5, 6, 7, 8});
  CHECK(rig.read(3) == Datagram{1, 2, 3});
  CHECK(rig.read(4) == Datagram{5, 6, 7, 8});
  for (const std::size_t size : {513, 576}) {
    rig.send(Datagram(size, 9));
    CHECK(rig.read(1000) == Datagram(size, 9));
  }
  rig.send(Datagram(577, 9));
  CHECK(rig.read(1000) == Datagram(576, 9));  // no report is so long
  const Datagram report{1, 2, 3};
  rig.link->write(report);
  Datagram into(8);
  CHECK(::recv(rig.peer, into.data(), into.size(), 0) == 3);
}

TEST_CASE("packet link: drain removes all waiting packets, including those fetched with an earlier one") {
  const TemporaryFolder folder;
  const PacketPeer rig(folder.path("peer"));
  CHECK(rig.link->drain() == 0);
  for (const std::size_t count : {1, 32, 33, 64, 70}) {
    for (std::size_t i = 0; i < count; ++i) rig.send({7});
    CHECK(rig.link->drain() == count);
    CHECK(rig.read(8, 0ns).empty());
  }
  for (int i = 0; i < 40; ++i) rig.send({7});
  CHECK(rig.read(8) == Datagram{7});
  CHECK(rig.link->drain() == 39);
  CHECK(rig.link->drain() == 0);
}

TEST_CASE("packet link: packets sent before the end are read, then the end is reported each time") {
  const TemporaryFolder folder;
  PacketPeer rig(folder.path("peer"));
  rig.send({1});
  rig.send({2});
  rig.go();
  CHECK(rig.read(8) == Datagram{1});
  CHECK(rig.read(8) == Datagram{2});
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { (void)rig.read(8); }) == "TB-HID-LOST");
  CHECK(fault_id_of([&] { (void)rig.link->drain(); }) == "TB-HID-LOST");
  const Datagram report{1, 2, 3};
  CHECK(fault_id_of([&] { rig.link->write(report); }) == "TB-HID-WRITE");
  PacketPeer at_once(folder.path("other"));
  at_once.go();
  CHECK(fault_id_of([&] { (void)at_once.read(8, 0ns); }) == "TB-HID-LOST");
  PacketPeer unread(folder.path("unread"));  // it closes with a report that it did not read
  unread.link->write(report);
  unread.go();
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { (void)unread.read(8); }) == "TB-HID-LOST");
  CHECK(fault_id_of([&] { (void)unread.link->drain(); }) == "TB-HID-LOST");
}

TEST_CASE("packet link: refuses a path that is empty, too long or without a listener") {
  const TemporaryFolder folder;
  const std::string begin = folder.path("x");
  const std::string longest = begin + std::string(107 - begin.size(), 'y');
  {
    const PacketPeer rig(longest);
    CHECK(rig.link->description() == "packet socket " + longest);
  }
  // Too long, of nobody, and of one that has gone.
  for (const std::string& path : {std::string(), longest + "y", folder.path("nobody"), longest})
    CHECK(fault_id_of([&] { (void)open_packet_link(path); }) == "TB-HID-OPEN");
}

TEST_CASE(
    "UDP, packet link, channel: late data of a busy simulated instrument is waited for, unless the timeout is 0") {
  const TemporaryFolder folder;
  const PacketPeer packets(folder.path("peer"));
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "test");
  UdpLink link("127.0.0.1", peer.port, "box");
  const Datagram datagram{1};
  link.send(datagram);
  sockaddr_in from{};
  socklen_t size = sizeof from;
  Datagram into(8);
  pollfd waited{peer.socket, POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
  REQUIRE(::recvfrom(peer.socket, into.data(), 8, 0, reinterpret_cast<sockaddr*>(&from), &size) == 1);
  const auto [a, b] = DescriptorChannel::make_pair();
  const DescriptorChannel one(a);
  DescriptorChannel other(b);
  {
    const auto held_end = std::make_unique<EndActivity>();  // it never finishes
    const auto begin = std::chrono::steady_clock::now();
    CHECK(link.receive(into, 0ns) == 0);
    CHECK(packets.read(8, 0ns).empty());
    CHECK_FALSE(other.receive(0ns));
    CHECK(std::chrono::steady_clock::now() - begin < 10s);
  }
  for (const Nanoseconds timeout : {Nanoseconds(1), Nanoseconds(kPatient)}) {
    const auto held_end = std::make_unique<EndActivity>();
    EndActivity& end = *held_end;
    std::thread worker = end.thread([&] {
      const auto late = [] { std::this_thread::sleep_for(20ms); };
      late();
      ::sendto(peer.socket, datagram.data(), 1, 0, reinterpret_cast<const sockaddr*>(&from), sizeof from);
      late();
      ::send(packets.peer, datagram.data(), 1, 0);
      late();
      one.send("late");
    });
    CHECK(link.receive(into, timeout) == 1);
    CHECK(packets.read(8, timeout) == datagram);
    CHECK(other.receive(timeout).has_value());
    worker.join();
  }
  ::close(peer.socket);
}

TEST_CASE("descriptor channel: packets have up to 131072 bytes, and the rest of a longer one is cut") {
  const auto [a, b] = DescriptorChannel::make_pair();
  const DescriptorChannel one(a);
  DescriptorChannel other(b);
  CHECK(one.socket() == a);
  for (const std::size_t size : {std::size_t{1}, std::size_t{131'071}, std::size_t{131'072}}) {
    const std::string text(size, 'x');
    CHECK(one.send(text));
    const auto packet = other.receive(kPatient);
    REQUIRE(packet);
    CHECK((packet->text == text));
    CHECK(packet->descriptor == -1);
  }
  CHECK(one.send(std::string(131'073, 'x')));
  CHECK(other.receive(kPatient)->text.size() == 131'072);
  CHECK_FALSE(one.send("text", 1'000'000));  // no descriptor of ours
  CHECK_FALSE(other.receive(0ns));
  CHECK_FALSE(other.closed());
}

namespace {

struct Ends {
  Ends() {
    const auto [a, b] = DescriptorChannel::make_pair();
    one = std::make_unique<DescriptorChannel>(a);
    other = std::make_unique<DescriptorChannel>(b);
  }
  std::unique_ptr<DescriptorChannel> one, other;
};

}  // namespace

TEST_CASE("descriptor channel: packets stay whole and in order, and silence is not the end") {
  Ends ends;
  CHECK_FALSE(ends.other->receive(0ms));
  CHECK_FALSE(ends.other->closed());
  const std::string large(60'000, 'x');
  CHECK(ends.one->send("feed"));
  CHECK(ends.one->send(large));
  CHECK(ends.other->receive(20s)->text == "feed");
  CHECK(ends.other->receive(20s)->text == large);
  ends.one.reset();
  CHECK_FALSE(ends.other->receive(20s));
  CHECK(ends.other->closed());
  CHECK_FALSE(ends.other->send("feed"));
}

TEST_CASE("descriptor channel: sending never blocks, even if the reader does not read") {
  Ends ends;
  int taken = 0;
  while (taken < 1'000'000 && ends.one->send("feed")) ++taken;
  CHECK(taken > 10);
  CHECK(taken < 1'000'000);
}

TEST_CASE("descriptor channel: a passed descriptor refers to the same connection and is close-on-exec") {
  Ends ends;
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  CHECK(ends.one->send("line", line[0]));
  auto packet = ends.other->receive(20s);
  REQUIRE(packet);
  CHECK(packet->text == "line");
  REQUIRE(packet->descriptor >= 0);
  CHECK((::fcntl(packet->descriptor, F_GETFD) & FD_CLOEXEC) != 0);
  ::close(line[0]);
  {
    const auto stream = adopt_stream(packet->descriptor, "handed over");
    const std::array<std::uint8_t, 2> bytes{1, 2};
    stream->write(bytes);
    std::array<std::uint8_t, 8> got{};
    CHECK(::recv(line[1], got.data(), got.size(), 0) == 2);
    REQUIRE(::send(line[1], "abc", 3, 0) == 3);
    CHECK(stream->read(got, 20s) == 3);
    CHECK(stream->description() == "handed over");
  }
  char byte = 0;
  CHECK(::recv(line[1], &byte, 1, 0) == 0);  // the stream has closed it
  ::close(line[1]);
}

namespace {

using UdpBytes = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("UDP: refuses host names, invalid ports and an address that cannot be connected to") {
  for (const auto& [host, port] :
       {std::pair{"localhost", 5}, std::pair{"127.0.0.1", 0}, std::pair{"127.0.0.1", 65536}}) {
    CHECK(fault_id_of([&, host = host, port = port] { const UdpLink link(host, port, "box"); }) == "TB-UDP-OPEN");
  }
  CHECK(fault_id_of([] { const UdpLink link("255.255.255.255", 5, "box"); }) == "TB-UDP-OPEN");
}

TEST_CASE("UDP: an absent peer and an oversized datagram are faults, and a timeout reads nothing") {
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

TEST_CASE("UDP: a renewed link has another port, and datagrams to the old one never arrive") {
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
