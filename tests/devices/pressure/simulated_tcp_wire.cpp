// The simulated module over TCP: units, bits, faults, many clients, and frames that are none.
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "devices/pressure/simulated_module.h"
#include "devices/wire/modbus/modbus_link.h"
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
  explicit SimulatedServer(const SimulatedModuleFaults& faults = {},
                           const ModuleProfile& profile = module_profile("beckhoff-ek9000"))
      : server(profile, 0, chamber, clock, faults) {}
  ManualClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
};

const TcpBytes kAskTime{1, 3, 0x11, 0x20, 0, 1}, kIsTime{1, 3, 2, 0x03, 0xE8};

}  // namespace

TEST_CASE("simulated module: a single unit answers every unit number, several answer only their own") {
  const SimulatedServer one;
  CHECK(one.server.serial_port().empty());
  const RawLine client(one.server.port());
  for (const std::uint8_t unit : TcpBytes{0, 1, 2, 255}) {
    REQUIRE(answers(client, {unit, 3, 0x11, 0x20, 0, 1}, {unit, 3, 2, 0x03, 0xE8}));
  }
  ManualClock clock;
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

TEST_CASE("simulated module: serves discrete inputs and coils, and one coil switches the dump valve") {
  ManualClock clock;
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

TEST_CASE("simulated module: reads and writes several registers per request, and refuses malformed requests") {
  const SimulatedServer moxa({}, module_profile("moxa-iologik-e1241"));
  const RawLine client(moxa.server.port());
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
  REQUIRE(answers(client, {1, 3, 0xFF, 0xFF, 0, 2}, {1, 0x83, 2}));  // over the end of all addresses
  for (const std::uint8_t function : TcpBytes{0, 1, 7, 8, 15, 17, 22, 24, 43}) {
    REQUIRE(answers(client, {1, function, 0, 0, 0, 1}, {1, static_cast<std::uint8_t>(function | 0x80U), 1}));
  }
}

TEST_CASE("simulated module: each injected fault has its specified effect over TCP") {
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

TEST_CASE("simulated module: stays silent or dies after the set number of requests, and is dead for every client") {
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

TEST_CASE("simulated module: bytes that are not a Modbus TCP frame close their connection") {
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

TEST_CASE("simulated module: serves 32 clients at once, and a further one after one disconnects") {
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

TEST_CASE("simulated module: listens on the given port, and a port in use is a fault that names it") {
  int port = 0;
  {
    SimulatedServer rig;
    port = rig.server.port();
    check_fault([&] { const SimulatedModule other(module_profile("generic"), port, rig.chamber, rig.clock); },
                "TB-SIM-LISTEN", {}, std::to_string(port));
  }
  ManualClock clock;
  TestChamber chamber(clock);
  const SimulatedModule again(module_profile("generic"), port, chamber, clock);
  CHECK(again.port() == port);
}

namespace {

const TcpBytes kReadLock = framed(1, {1, 3, 0x11, 0x24, 0, 1}), kLockIsOne = framed(1, {1, 3, 2, 0, 1});

}  // namespace

TEST_CASE("simulated module: accepts counts up to the protocol's limits, and refuses one more as an illegal value") {
  SimulatedServer module;
  const RawLine client(module.server.port());
  std::uint8_t number = 0;
  // The exception of a PDU; registers from 0x2000 on are none, so that what passes as a value is refused as an address.
  const auto exception = [&](TcpBytes pdu) {
    const int function = pdu[0];
    pdu.insert(pdu.begin(), 1);
    client.send(framed(++number, pdu));
    const TcpBytes reply = client.receive(9);
    return reply.size() == 9 && reply[7] == (function | 0x80) ? int{reply[8]} : -1;
  };
  const auto reading = [](int function, std::size_t count) {
    return TcpBytes{static_cast<std::uint8_t>(function), 0x20, 0, static_cast<std::uint8_t>(count >> 8U),
                    static_cast<std::uint8_t>(count & 0xFFU)};
  };
  for (const auto& [function, most] : {std::pair{2, 2000U}, std::pair{3, 125U}, std::pair{4, 125U}}) {
    INFO("function " << function);
    CHECK(exception(reading(function, 1)) == 2);
    CHECK(exception(reading(function, most)) == 2);
    CHECK(exception(reading(function, most + 1)) == 3);
    CHECK(exception(reading(function, 0)) == 3);
  }
  CHECK(exception({5, 0x20, 0, 0xFF, 0}) == 2);
  CHECK(exception({5, 0x20, 0, 0, 0}) == 2);
  CHECK(exception({5, 0x20, 0, 0, 1}) == 3);
  const auto writing = [](std::size_t count, std::size_t sent, std::size_t said) {
    TcpBytes pdu{16, 0x20, 0, 0, static_cast<std::uint8_t>(count), static_cast<std::uint8_t>(said)};
    pdu.resize(pdu.size() + 2 * sent);
    return pdu;
  };
  CHECK(exception(writing(1, 1, 2)) == 2);
  CHECK(exception(writing(123, 123, 246)) == 2);
  CHECK(exception(writing(0, 0, 0)) == 3);
  CHECK(exception(writing(2, 1, 4)) == 3);
  CHECK(exception(writing(1, 1, 4)) == 3);
  const auto both = [](std::size_t read, std::size_t written, std::size_t said) {
    TcpBytes pdu{23,
                 0x20,
                 0,
                 0,
                 static_cast<std::uint8_t>(read),
                 0x20,
                 0,
                 0,
                 static_cast<std::uint8_t>(written),
                 static_cast<std::uint8_t>(said)};
    pdu.resize(pdu.size() + 2 * written);
    return pdu;
  };
  CHECK(exception(both(1, 1, 2)) == 2);
  CHECK(exception(both(125, 121, 242)) == 2);
  CHECK(exception(both(126, 1, 2)) == 3);
  CHECK(exception(both(0, 1, 2)) == 3);
  CHECK(exception(both(1, 0, 0)) == 3);
  CHECK(exception(both(1, 1, 4)) == 3);
}

TEST_CASE("simulated module: half a request delays no other client, pieces are joined, several are answered in turn") {
  SimulatedServer module;
  const RawLine slow(module.server.port());
  slow.send(TcpBytes(kReadLock.begin(), kReadLock.begin() + 5));
  const RawLine quick(module.server.port());
  quick.send(kReadLock);
  CHECK(quick.receive(11) == kLockIsOne);
  slow.send(TcpBytes(kReadLock.begin() + 5, kReadLock.end()));
  CHECK(slow.receive(11) == kLockIsOne);
  TcpBytes twice = kReadLock;
  twice.insert(twice.end(), kReadLock.begin(), kReadLock.end());
  slow.send(twice);
  CHECK(slow.receive(22).size() == 22);
}

TEST_CASE("simulated module: an exception in the chamber port is a Modbus exception, and the server continues") {
  class Failing final : public ChamberPort {
    void drive(Volts, Nanoseconds, Volts) override { throw std::runtime_error("physics"); }
    void dump(bool) override { throw std::runtime_error("physics"); }
    Volts feedback() override { throw std::runtime_error("physics"); }
    Volts reference() override { return Volts(0.0); }
  } failing;
  ManualClock clock;
  const SimulatedModule server(module_profile("beckhoff-ek9000"), 0, failing, clock);
  ModbusLink link({"127.0.0.1", server.port(), 1, 20s}, "module", clock);
  std::uint16_t value = 0;
  CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) == "TB-MODBUS-EXCEPTION");
  CHECK(fault_id_of([&] { link.read_input_registers(1, std::span(&value, 1)); }) == "none");
}

TEST_CASE("simulated module: the write lock becomes free when its holder disconnects, in any order of connecting") {
  SimulatedServer module;
  for (int round = 0; round < 50; ++round) {
    ModbusLink older({"127.0.0.1", module.server.port(), 1, 20s}, "older", module.clock);
    ModbusLink holder({"127.0.0.1", module.server.port(), 1, 20s}, "holder", module.clock);
    const std::uint16_t value = 5;
    std::uint16_t read = 0;
    older.read_holding_registers(0x0800, std::span(&read, 1));
    holder.write_registers(0x0800, std::span(&value, 1));
    holder.close();
    REQUIRE(fault_id_of([&] { older.write_registers(0x0800, std::span(&value, 1)); }) == "none");
  }
}
