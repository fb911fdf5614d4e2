#include "devices/wire/modbus/modbus_link.h"

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "devices/pressure/simulated_module.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// Long where an answer is to come, short where none will.
ModbusEndpoint at(int port, Nanoseconds timeout = kPatient) { return {"127.0.0.1", port, 1, timeout}; }

std::uint16_t read_one(ModbusLink& link, int address) {
  std::uint16_t value = 0;
  link.read_input_registers(address, std::span(&value, 1));
  return value;
}

struct ModbusModule {
  explicit ModbusModule(SimulatedModuleFaults faults = {})
      : server(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults) {}
  TurnedClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
};

}  // namespace

TEST_CASE("modbus link: each function code carries its values") {
  ModbusModule module;
  ModbusLink link(at(module.server.port()), "module", module.clock);
  const std::array<std::uint16_t, 1> out{0x1234};
  link.write_registers(0x0800, out);
  std::array<std::uint16_t, 1> back{};
  link.read_holding_registers(0x0800, back);
  CHECK(back == out);
  module.chamber.reference_volts = Volts(10.0);
  std::array<std::uint16_t, 2> in{};
  link.read_input_registers(0x0000, in);
  CHECK(in == std::array<std::uint16_t, 2>{0x1234, 0x7FFF});
  const std::array<std::uint16_t, 1> other{0x0777};
  link.write_and_read_registers(0x0800, other, 0x0000, in);
  CHECK(in == std::array<std::uint16_t, 2>{0x0777, 0x7FFF});  // written first, then read
  CHECK(link.exchanges() == 4);
  CHECK(module.clock.now() == 0ns);
}

TEST_CASE("modbus link: silence costs one response timeout of process time, and the error names request and device") {
  ModbusModule module({.silent_after_requests = 1});
  ModbusLink link(at(module.server.port(), kShort), "module", module.clock);
  CHECK(read_one(link, 1) == 0);
  check_fault([&] { read_one(link, 1); }, "TB-MODBUS-TIMEOUT", "module", "0x0001");
  CHECK(module.clock.now() == kShort);
}

TEST_CASE("modbus link: after a lost reply the next request gets its own answer") {
  ScriptedServer server([](int number, int socket, const Bytes& request) {
    if (number == 1) return;
    ScriptedServer::send(socket, ScriptedServer::answer(request, {static_cast<std::uint16_t>(100 + number)}));
  });
  TurnedClock clock;
  ModbusLink link(at(server.port(), kShort), "module", clock);
  CHECK(read_one(link, 0) == 100);
  CHECK(fault_id_of([&] { read_one(link, 1); }) == "TB-MODBUS-TIMEOUT");
  CHECK(read_one(link, 2) == 102);
  CHECK(read_one(link, 3) == 103);
}

TEST_CASE("modbus link: a late reply is never taken for an answer") {
  // The first answer is held back until the second request is there, and then sent before the second's own answer.
  Bytes held;
  int held_on = -1;
  ScriptedServer server([&](int number, int socket, const Bytes& request) {
    if (number == 0) {
      held = ScriptedServer::answer(request, {111});
      held_on = socket;
      return;
    }
    if (number == 1) ScriptedServer::send(held_on, held);
    ScriptedServer::send(socket, ScriptedServer::answer(request, {static_cast<std::uint16_t>(222 + number)}));
  });
  TurnedClock clock;
  ModbusLink link(at(server.port(), kShort), "module", clock);
  CHECK(fault_id_of([&] { read_one(link, 0); }) == "TB-MODBUS-TIMEOUT");
  CHECK(read_one(link, 0) == 223);
  CHECK(read_one(link, 0) == 224);
}

TEST_CASE("modbus link: each of a thousand requests has a number of its own, in both its bytes") {
  std::array<std::atomic<bool>, 1 << 16> used{};
  ScriptedServer server([&](int, int socket, const Bytes& request) {
    const bool fresh = !used.at(request[0] * 256U + request[1]).exchange(true);
    ScriptedServer::send(socket, ScriptedServer::answer(request, {fresh ? std::uint16_t{1} : std::uint16_t{0}}));
  });
  TurnedClock clock;
  ModbusLink link(at(server.port()), "module", clock);
  int fresh = 0;
  for (int i = 0; i < 1000; ++i) fresh += read_one(link, 0);
  CHECK(fresh == 1000);
}

TEST_CASE("modbus link: a reply that comes in pieces is one reply") {
  ScriptedServer server([](int, int socket, const Bytes& request) {
    const Bytes reply = ScriptedServer::answer(request, {0x1234});
    for (const std::uint8_t byte : reply) {
      ScriptedServer::send(socket, {byte});
      std::this_thread::sleep_for(5ms);
    }
  });
  TurnedClock clock;
  ModbusLink link(at(server.port()), "module", clock);
  CHECK(read_one(link, 0) == 0x1234);
  CHECK(read_one(link, 1) == 0x1234);
}

TEST_CASE("modbus link: a server that dies breaks the connection, then refuses") {
  ModbusModule module({.dead_after_requests = 1});
  ModbusLink link(at(module.server.port()), "module", module.clock);
  CHECK(read_one(link, 1) == 0);
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { read_one(link, 1); }) == "TB-MODBUS-CONNECT");
  CHECK(module.clock.now() == 0ns);  // a refusal costs no time
}

TEST_CASE("modbus link: answers that do not fit are refused and leave nothing behind") {
  const auto spoil = [](int kind, const Bytes& request) {
    auto reply = ScriptedServer::answer(request, {0xDEAD});
    if (kind == 0) reply[1] = static_cast<std::uint8_t>(reply[1] + 1);  // transaction of another request
    if (kind == 1) reply[7] = 3;                                        // another function
    if (kind == 2) reply = ScriptedServer::answer(request, {1, 2});     // more registers than requested
    if (kind == 3) reply.resize(reply.size() - 1);                      // the last byte never comes
    if (kind == 4) reply[6] = static_cast<std::uint8_t>(reply[6] + 1);  // another unit behind the same gateway
    if (kind == 5) reply[3] = 1;                                        // not Modbus
    return reply;
  };
  for (int kind = 0; kind < 6; ++kind) {
    INFO("kind " << kind);
    ScriptedServer server([&](int number, int socket, const Bytes& request) {
      ScriptedServer::send(socket, number == 0 ? spoil(kind, request) : ScriptedServer::answer(request, {42}));
    });
    TurnedClock clock;
    ModbusLink link(at(server.port(), kShort), "module", clock);
    const std::string id = fault_id_of([&] { read_one(link, 0); });
    CHECK(id == (kind == 3 ? "TB-MODBUS-TIMEOUT" : "TB-MODBUS-PROTOCOL"));
    CHECK(read_one(link, 0) == 42);
  }
}
