// Replies of the simulated module that come late or damaged, byte by byte on the wire.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <vector>

#include "devices/pressure/simulated_module.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

using Bytes = std::vector<std::uint8_t>;

// One register asked for, and the reply that holds 1, as Modbus TCP frames of this transaction.
Bytes question(std::uint8_t transaction) { return {0, transaction, 0, 0, 0, 6, 1, 3, 0x11, 0x24, 0, 1}; }
Bytes reply_to(std::uint8_t transaction, std::uint8_t function = 3) {
  return {0, transaction, 0, 0, 0, 5, 1, function, 2, 0, 1};
}

Bytes operator+(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

}  // namespace

TEST_CASE(
    "a simulated module's late reply comes once, before the next one, and a corrupt one has another function code") {
  TurnedClock clock;
  TestChamber chamber{clock};
  std::atomic<InjectedFault> next{InjectedFault::kNone};
  SimulatedModuleFaults faults;
  faults.inject = [&] { return next.load(); };
  const SimulatedModule server(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults);
  const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{20, 0};
  ::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  REQUIRE(::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const auto send = [&](std::uint8_t transaction) {
    const Bytes bytes = question(transaction);
    REQUIRE(::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size()));
  };
  const auto received = [&](std::size_t size) {
    Bytes bytes(size);
    const ssize_t got = ::recv(client, bytes.data(), size, MSG_WAITALL);
    bytes.resize(static_cast<std::size_t>(got > 0 ? got : 0));
    return bytes;
  };
  send(1);
  CHECK(received(11) == reply_to(1));
  next = InjectedFault::kCorrupt;
  send(2);
  CHECK(received(11) == reply_to(2, 0x13));
  next = InjectedFault::kLate;
  send(3);
  const timeval short_patience{0, 200'000};
  ::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &short_patience, sizeof short_patience);
  CHECK(received(1).empty());
  ::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  next = InjectedFault::kNone;
  send(4);
  CHECK(received(22) == reply_to(3) + reply_to(4));
  send(5);
  CHECK(received(11) == reply_to(5));
  send(6);
  CHECK(received(11) == reply_to(6));
  ::close(client);
}
