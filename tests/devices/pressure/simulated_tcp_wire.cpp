// The simulated module over TCP: units, bits, faults, many clients, and frames that are none.
#include <catch2/catch.hpp>
#include <memory>

#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/next_fault.h"
#include "tests/devices/pressure/raw_clients.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using TcpBytes = RawLine::Bytes;

// A frame with this transaction.
TcpBytes framed(std::uint8_t transaction, const TcpBytes& body) {
  TcpBytes frame{0,
                 transaction,
                 0,
                 0,
                 static_cast<std::uint8_t>(body.size() >> 8U),
                 static_cast<std::uint8_t>(body.size() & 0xFFU)};
  frame.insert(frame.end(), body.begin(), body.end());
  return frame;
}

bool answers(const RawLine& client, const TcpBytes& request, const TcpBytes& answer) {
  client.send(framed(9, request));
  const TcpBytes expected = framed(9, answer);
  return client.receive(expected.size()) == expected;
}

struct SimulatedServer {
  explicit SimulatedServer(const SimulatedModuleFaults& faults = {})
      : server(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults) {}
  TurnedClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
};

const TcpBytes kAskTime{1, 3, 0x11, 0x20, 0, 1}, kIsTime{1, 3, 2, 0x03, 0xE8};

}  // namespace

TEST_CASE("simulated module: one unit answers every number, of several each its own") {
  const SimulatedServer one;
  CHECK(one.server.serial_port().empty());
  const RawLine client(one.server.port());
  for (const std::uint8_t unit : TcpBytes{0, 1, 2, 255}) {
    REQUIRE(answers(client, {unit, 3, 0x11, 0x20, 0, 1}, {unit, 3, 2, 0x03, 0xE8}));
  }
  TurnedClock clock;
  TestChamber chamber(clock);
  SimulatedModule two({{1, module_profile("generic"), {}}, {2, module_profile("generic"), {}}},
                      SimulatedModule::Wire::kTcp, 0, chamber, clock);
  const RawLine other(two.port());
  REQUIRE(answers(other, {2, 6, 0, 0, 0, 5}, {2, 6, 0, 0, 0, 5}));
  REQUIRE(answers(other, {1, 3, 0, 0, 0, 1}, {1, 3, 2, 0, 0}));
  REQUIRE(answers(other, {2, 3, 0, 0, 0, 1}, {2, 3, 2, 0, 5}));
  other.send(framed(1, {3, 3, 0, 0, 0, 1}));
  CHECK(other.is_silent());
}

TEST_CASE("simulated module: discrete inputs and coils, and the valve on one of them") {
  TurnedClock clock;
  TestChamber chamber(clock);
  ModuleProfile profile = module_profile("moxa-iologik-e1241");
  profile.dump_coil = 3;
  SimulatedModule server({{1, profile, {}, true}}, SimulatedModule::Wire::kTcp, 0, chamber, clock);
  const RawLine client(server.port());
  REQUIRE(answers(client, {1, 2, 0x10, 0x10, 0, 4}, {1, 2, 1, 0x0F}));
  REQUIRE(answers(client, {1, 5, 0x10, 0x21, 0xFF, 0}, {1, 5, 0x10, 0x21, 0xFF, 0}));
  REQUIRE(answers(client, {1, 2, 0x10, 0x10, 0, 4}, {1, 2, 1, 0x0D}));
  REQUIRE(answers(client, {1, 2, 0x10, 0x11, 0, 1}, {1, 2, 1, 0}));
  REQUIRE(answers(client, {1, 2, 0x10, 0x10, 0, 5}, {1, 0x82, 2}));
  CHECK(chamber.dumping);
  REQUIRE(answers(client, {1, 5, 0, 3, 0xFF, 0}, {1, 5, 0, 3, 0xFF, 0}));
  CHECK_FALSE(chamber.dumping);
  REQUIRE(answers(client, {1, 5, 0, 3, 0, 0}, {1, 5, 0, 3, 0, 0}));
  CHECK(chamber.dumping);
  REQUIRE(answers(client, {1, 5, 0, 3, 0xFF, 1}, {1, 0x85, 3}));
  REQUIRE(answers(client, {1, 5, 0, 4, 0xFF, 0}, {1, 0x85, 2}));
}

TEST_CASE("simulated module: several registers in one request, each at its place") {
  TurnedClock clock;
  TestChamber chamber(clock);
  ModuleProfile profile = module_profile("moxa-iologik-e1241");
  SimulatedModule server(profile, 0, chamber, clock);
  const RawLine client(server.port());
  REQUIRE(answers(client, {1, 16, 0x04, 0x00, 0, 4, 8, 1, 2, 3, 4, 5, 6, 7, 8}, {1, 16, 0x04, 0x00, 0, 4}));
  REQUIRE(answers(client, {1, 3, 0x04, 0x01, 0, 2}, {1, 3, 4, 3, 4, 5, 6}));
  REQUIRE(answers(client, {1, 23, 0x04, 0x02, 0, 2, 0x04, 0x01, 0, 2, 4, 9, 8, 7, 6}, {1, 23, 4, 7, 6, 7, 8}));
  REQUIRE(answers(client, {1, 3, 0x04, 0x00, 0, 4}, {1, 3, 8, 1, 2, 9, 8, 7, 6, 7, 8}));
  // Refused in one half, neither is done.
  REQUIRE(answers(client, {1, 23, 0x04, 0x03, 0, 2, 0x04, 0x00, 0, 1, 2, 0, 0}, {1, 0x97, 2}));
  REQUIRE(answers(client, {1, 23, 0x04, 0x00, 0, 1, 0x04, 0x03, 0, 2, 4, 0, 0, 0, 0}, {1, 0x97, 2}));
  REQUIRE(answers(client, {1, 3, 0x04, 0x00, 0, 1}, {1, 3, 2, 1, 2}));
  // Requests that are longer or shorter than what they say.
  REQUIRE(answers(client, {1, 3, 0x04, 0x00, 0, 1, 0}, {1, 0x83, 3}));
  REQUIRE(answers(client, {1, 2, 0x04, 0x00, 0, 1, 0}, {1, 0x82, 3}));
  REQUIRE(answers(client, {1, 5, 0x04, 0x00, 0, 0, 0}, {1, 0x85, 3}));
  REQUIRE(answers(client, {1, 6, 0x04, 0x00, 0, 1, 0}, {1, 0x86, 3}));
  REQUIRE(answers(client, {1, 6, 0x04, 0x00, 0}, {1, 0x86, 3}));
  REQUIRE(answers(client, {1, 16, 0x04, 0x00, 0, 1, 2, 0, 1, 0}, {1, 0x90, 3}));
  REQUIRE(answers(client, {1, 23, 0x04, 0x00, 0, 1, 0x04, 0x00, 0}, {1, 0x97, 3}));
  REQUIRE(answers(client, {1, 23, 0x04, 0x00, 0, 1, 0x04, 0x00, 0, 1, 2, 0}, {1, 0x97, 3}));
  for (const std::uint8_t function : TcpBytes{0, 1, 7, 8, 15, 17, 22, 24, 43}) {
    REQUIRE(answers(client, {1, function, 0, 0, 0, 1}, {1, static_cast<std::uint8_t>(function | 0x80U), 1}));
  }
}

TEST_CASE("simulated module: each injected fault over TCP") {
  SimulatedModuleFaults faults;
  NextFault next(faults);
  SimulatedServer rig(faults);
  const RawLine client(rig.server.port());
  REQUIRE(answers(client, kAskTime, kIsTime));
  next = InjectedFault::kSilent;
  next.meets([&] { client.send(framed(1, kAskTime)); });
  CHECK(client.is_silent());
  next = InjectedFault::kRefused;
  REQUIRE(answers(client, {1, 6, 0x11, 0x20, 1, 0}, {1, 0x86, 4}));
  next = InjectedFault::kNone;
  REQUIRE(answers(client, kAskTime, kIsTime));  // the refused one has done nothing
  REQUIRE(answers(client, {1, 6, 0x11, 0x20, 1, 0}, {1, 6, 0x11, 0x20, 1, 0}));
  REQUIRE(answers(client, {1, 4, 0, 1, 0, 1}, {1, 4, 2, 0, 0}));
  rig.chamber.reference_volts = Volts(10.0);
  next = InjectedFault::kStale;
  REQUIRE(answers(client, {1, 4, 0, 1, 0, 1}, {1, 4, 2, 0, 0}));
  next = InjectedFault::kNone;
  REQUIRE(answers(client, kAskTime, {1, 3, 2, 1, 0}));
  REQUIRE(answers(client, {1, 4, 0, 1, 0, 1}, {1, 4, 2, 0x7F, 0xFF}));
  next = InjectedFault::kCorrupt;
  REQUIRE(answers(client, {1, 3, 0x30, 0, 0, 1}, {1, 0x93, 2}));  // an exception's function code, too
  // A late answer waits for its own client.
  next = InjectedFault::kLate;
  next.meets([&] { client.send(framed(7, kAskTime)); });
  CHECK(client.is_silent());
  next = InjectedFault::kNone;
  const RawLine other(rig.server.port());
  REQUIRE(answers(other, kAskTime, {1, 3, 2, 1, 0}));
  client.send(framed(8, kAskTime));
  const TcpBytes late = framed(7, {1, 3, 2, 1, 0});
  CHECK(client.receive(late.size()) == late);
  const TcpBytes own = framed(8, {1, 3, 2, 1, 0});
  CHECK(client.receive(own.size()) == own);
  next = InjectedFault::kUnplugged;
  client.send(framed(1, kAskTime));
  REQUIRE(client.is_closed());
  next = InjectedFault::kNone;
  REQUIRE(answers(other, kAskTime, {1, 3, 2, 1, 0}));
  const RawLine again(rig.server.port());
  REQUIRE(answers(again, kAskTime, {1, 3, 2, 1, 0}));
}

TEST_CASE("simulated module: silent or dead after so many requests, dead for every client") {
  for (const long after : {0L, 1L, 2L}) {
    INFO(after << " requests");
    const SimulatedServer silent({.silent_after_requests = after});
    const SimulatedServer dead({.dead_after_requests = after});
    const RawLine to_silent(silent.server.port());
    const RawLine to_dead(dead.server.port());
    const RawLine beside(dead.server.port());
    for (long i = 0; i < after; ++i) {
      REQUIRE(answers(to_silent, kAskTime, kIsTime));
      REQUIRE(answers(to_dead, kAskTime, kIsTime));
    }
    to_silent.send(framed(1, kAskTime));
    CHECK(to_silent.is_silent());
    to_dead.send(framed(1, kAskTime));
    REQUIRE(to_dead.is_closed());
    REQUIRE(beside.is_closed());
  }
}

TEST_CASE("simulated module: bytes that are no frame close their connection") {
  const SimulatedServer rig;
  const TcpBytes frames[] = {{0, 1, 1, 0, 0, 6, 1, 3, 0, 0, 0, 1},  // another protocol, in either byte
                             {0, 1, 0, 1, 0, 6, 1, 3, 0, 0, 0, 1},
                             {0, 1, 0, 0, 0, 0, 1},  // no room for unit and function
                             {0, 1, 0, 0, 0, 1, 1},
                             {0, 1, 0, 0, 0, 255, 1},  // longer than any frame of Modbus
                             {0, 1, 0, 0, 1, 0, 1}};
  for (const TcpBytes& frame : frames) {
    const RawLine client(rig.server.port());
    client.send(frame);
    REQUIRE(client.is_closed());
  }
  const RawLine client(rig.server.port());
  client.send({0, 1, 0, 0, 0, 2, 1, 3});  // the shortest, and the longest
  CHECK(client.receive(9) == framed(1, {1, 0x83, 3}));
  TcpBytes longest{1, 3};
  longest.resize(254);
  REQUIRE(answers(client, longest, {1, 0x83, 3}));
}

TEST_CASE("simulated module: 32 clients at once, a further one when one of them has gone") {
  const SimulatedServer rig;
  std::vector<std::unique_ptr<RawLine>> clients;
  for (int i = 0; i < 32; ++i) {
    clients.push_back(std::make_unique<RawLine>(rig.server.port()));
    REQUIRE(answers(*clients.back(), kAskTime, kIsTime));
  }
  // 0x1022: connections
  REQUIRE(answers(*clients[0], {1, 3, 0x10, 0x22, 0, 1}, {1, 3, 2, 0, 32}));
  const RawLine further(rig.server.port());
  further.send(framed(9, kAskTime));
  CHECK(further.is_silent());
  clients[5].reset();
  const TcpBytes answer = framed(9, kIsTime);
  CHECK(further.receive(answer.size()) == answer);
  REQUIRE(answers(*clients[0], {1, 3, 0x10, 0x22, 0, 1}, {1, 3, 2, 0, 32}));
}

TEST_CASE("simulated module: the port that it was given, or why not") {
  int port = 0;
  {
    SimulatedServer rig;
    port = rig.server.port();
    check_fault([&] { const SimulatedModule other(module_profile("generic"), port, rig.chamber, rig.clock); },
                "TB-SIM-LISTEN", {}, std::to_string(port));
  }
  TurnedClock clock;
  TestChamber chamber(clock);
  const SimulatedModule again(module_profile("generic"), port, chamber, clock);
  CHECK(again.port() == port);
}
