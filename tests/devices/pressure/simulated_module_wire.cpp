#include "devices/pressure/simulated_module.h"

#include <catch2/catch.hpp>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"
#include "tests/devices/pressure/raw_clients.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Module {
  TurnedClock clock;
  TestChamber chamber{clock};
  SimulatedModule server{module_profile("beckhoff-ek9000"), 0, chamber, clock};
};

const Bytes kReadLock{0, 1, 0, 0, 0, 6, 1, 3, 0x11, 0x24, 0, 1};
const Bytes kLockIsOne{0, 1, 0, 0, 0, 5, 1, 3, 2, 0, 1};

}  // namespace

TEST_CASE("simulated module: FC 6 writes and echoes") {
  Module module;
  const RawLine client(module.server.port());
  const Bytes write{0, 9, 0, 0, 0, 6, 1, 6, 0x08, 0x00, 0x20, 0x00};
  client.send(write);
  CHECK(client.receive(12) == write);
  CHECK(module.chamber.output().value() == Approx(2.5).margin(0.001));
}

TEST_CASE("simulated module: illegal requests get their exception at once") {
  Module module;
  const RawLine client(module.server.port());
  const auto exception = [&](const Bytes& request) {
    client.send(request);
    const Bytes reply = client.receive(9);
    return reply.size() == 9 && reply[7] == (request[7] | 0x80U) ? int{reply[8]} : -1;
  };
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 1, 0, 0, 0, 1}) == 1);            // coils: no such function
  CHECK(exception({0, 1, 0, 0, 0, 4, 1, 0x2B, 0x0E, 1}) == 1);            // neither, and of another length
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 3, 0x20, 0, 0, 1}) == 2);         // no such register
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 3, 0xFF, 0xFF, 0, 2}) == 2);      // over the end of all addresses
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 6, 0, 0, 0, 1}) == 2);            // inputs cannot be written
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 0}) == 3);            // no registers
  CHECK(exception({0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 126}) == 3);          // too many
  CHECK(exception({0, 1, 0, 0, 0, 9, 1, 16, 8, 0, 0, 2, 2, 0, 1}) == 3);  // counts that disagree
  CHECK(exception({0, 1, 0, 0, 0, 3, 1, 3, 0}) == 3);                     // cut short
  CHECK(exception({0, 1, 0, 0, 0, 13, 1, 23, 0x20, 0, 0, 1, 8, 0, 0, 1, 2, 0, 9}) == 2);
  CHECK(module.chamber.output() == Volts(0.0));  // a refused FC 23 has not written either
  client.send(kReadLock);
  CHECK(client.receive(11) == kLockIsOne);
}

TEST_CASE("simulated module: counts up to the protocol's limits pass, one more is refused as a value") {
  Module module;
  const RawLine client(module.server.port());
  std::uint16_t number = 0;
  // The exception of a PDU; registers from 0x2000 on are none, so that what passes as a value is refused as an address.
  const auto exception = [&](Bytes pdu) {
    Bytes frame{0,
                static_cast<std::uint8_t>(++number),
                0,
                0,
                static_cast<std::uint8_t>((pdu.size() + 1) >> 8U),
                static_cast<std::uint8_t>((pdu.size() + 1) & 0xFFU),
                1};
    frame.insert(frame.end(), pdu.begin(), pdu.end());
    client.send(frame);
    const Bytes reply = client.receive(9);
    return reply.size() == 9 && reply[7] == (pdu[0] | 0x80U) ? int{reply[8]} : -1;
  };
  const auto reading = [](int function, std::size_t count) {
    return Bytes{static_cast<std::uint8_t>(function), 0x20, 0, static_cast<std::uint8_t>(count >> 8U),
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
    Bytes pdu{16, 0x20, 0, 0, static_cast<std::uint8_t>(count), static_cast<std::uint8_t>(said)};
    pdu.resize(pdu.size() + 2 * sent);
    return pdu;
  };
  CHECK(exception(writing(1, 1, 2)) == 2);
  CHECK(exception(writing(123, 123, 246)) == 2);
  CHECK(exception(writing(0, 0, 0)) == 3);
  CHECK(exception(writing(2, 1, 4)) == 3);
  CHECK(exception(writing(1, 1, 4)) == 3);
  const auto both = [](std::size_t read, std::size_t written, std::size_t said) {
    Bytes pdu{23,
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
  Module module;
  const RawLine slow(module.server.port());
  slow.send(Bytes(kReadLock.begin(), kReadLock.begin() + 5));
  const RawLine quick(module.server.port());
  quick.send(kReadLock);
  CHECK(quick.receive(11) == kLockIsOne);
  slow.send(Bytes(kReadLock.begin() + 5, kReadLock.end()));
  CHECK(slow.receive(11) == kLockIsOne);
  Bytes twice = kReadLock;
  twice.insert(twice.end(), kReadLock.begin(), kReadLock.end());
  slow.send(twice);
  CHECK(slow.receive(22).size() == 22);
}

TEST_CASE("simulated module: a failing chamber port is a failing device, and the program lives on") {
  class Failing final : public ChamberPort {
    void drive(Volts, Nanoseconds, Volts) override { throw std::runtime_error("physics"); }
    void dump(bool) override { throw std::runtime_error("physics"); }
    Volts feedback() override { throw std::runtime_error("physics"); }
    Volts reference() override { return Volts(0.0); }
  } failing;
  TurnedClock clock;
  const SimulatedModule server(module_profile("beckhoff-ek9000"), 0, failing, clock);
  ModbusLink link({"127.0.0.1", server.port(), 1, 20s}, "module", clock);
  std::uint16_t value = 0;
  CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) == "TB-MODBUS-EXCEPTION");
  CHECK(fault_id_of([&] { link.read_input_registers(1, std::span(&value, 1)); }) == "none");
}

TEST_CASE("simulated module: the write lock passes on when its holder hangs up, in any order of connecting") {
  Module module;
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
