#include "devices/pressure/module_registers.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct Map {
  TurnedClock clock;
  TestChamber chamber{clock};
  ModuleRegisters registers{SimulatedUnit{1, module_profile("beckhoff-ek9000"), {}}, chamber, clock};

  Refusal write(int client, int address, std::uint16_t value) {
    registers.turn();
    return registers.write(client, address, std::span(&value, 1));
  }
  int read(int client, int address, int function = 3) {
    registers.turn();
    std::uint16_t value = 0;
    return registers.read(client, function, address, std::span(&value, 1)) == Refusal::kNone ? value : -1;
  }
};

constexpr int kOutput = 0x0800;

}  // namespace

TEST_CASE("module registers: power-up values") {
  Map map;
  CHECK(map.read(1, 0x1120) == 1000);
  CHECK(map.read(1, 0x1121) == 0);
  CHECK(map.read(1, 0x1122) == 1);
  CHECK(map.read(1, 0x1123) == 0);
  CHECK(map.read(1, 0x1124) == 1);
  CHECK(map.read(1, 0x1020) == 0);
  CHECK(map.read(1, 0x1021) == 0);
  CHECK(map.read(1, 0x1022) == 0);
  CHECK(map.read(1, kOutput) == 0);
}

TEST_CASE("module registers: addresses outside the map are refused") {
  Map map;
  for (const int address : {0x0002, 0x07FF, 0x0801, 0x101F, 0x1023, 0x111F, 0x1125, 0xFFFF}) {
    INFO("address " << address);
    CHECK(map.registers.check_read(3, address, 1) == Refusal::kAddress);
    CHECK(map.write(1, address, 1) == Refusal::kAddress);
  }
  CHECK(map.registers.check_read(3, 0x0001, 2) == Refusal::kAddress);  // runs over the end
  CHECK(map.registers.check_read(3, 0x0000, 2) == Refusal::kNone);
  CHECK(map.registers.check_read(4, 0x0800, 1) == Refusal::kAddress);  // FC 4 knows the inputs alone
  CHECK(map.write(1, 0x0000, 1) == Refusal::kAddress);
  CHECK(map.write(1, 0x1021, 1) == Refusal::kAddress);
  CHECK(map.write(1, 0x1120, 60001) == Refusal::kValue);
  CHECK(map.write(1, 0x1120, 0) == Refusal::kValue);
  CHECK(map.write(1, 0x1122, 3) == Refusal::kValue);
  CHECK(map.write(1, 0x1123, 2) == Refusal::kValue);
}

TEST_CASE("module registers: inputs are live, scaled and clipped") {
  Map map;
  map.chamber.reference_volts = Volts(10.0);
  CHECK(map.read(1, 1, 4) == 0x7FFF);
  map.chamber.reference_volts = Volts(11.0);
  CHECK(map.read(1, 1, 4) == 0x7FFF);
  map.chamber.reference_volts = Volts(-5.0);
  CHECK(static_cast<std::int16_t>(map.read(1, 1)) == -16384);
  CHECK(map.write(1, kOutput, 0x4000) == Refusal::kNone);
  CHECK(map.read(1, 0) == 0x4000);  // the chamber's feedback is its drive
  CHECK(map.write(1, kOutput, 0xC000) == Refusal::kNone);
  CHECK(map.read(1, kOutput) == 0xC000);
  CHECK(map.chamber.output() == Volts(0.0));  // a unipolar terminal clips negative words
}

TEST_CASE("module registers: the watchdog falls back in process time and refuses until reset") {
  Map map;
  REQUIRE(map.write(1, 0x1122, 0) == Refusal::kNone);
  map.clock.wait_until(1h);  // not armed before the first write
  CHECK(map.read(1, 0x1021) == 0);
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  map.clock.wait_until(1h + 400ms);
  CHECK(map.read(1, 0x1020) == 600);
  map.clock.wait_until(1h + 999ms);
  CHECK(map.read(1, kOutput) == 1000);  // a reading does not feed type 0
  CHECK(map.chamber.output() > Volts(0.0));
  map.clock.wait_until(1h + 1000ms);
  CHECK(map.chamber.output() == Volts(0.0));
  CHECK(map.read(1, kOutput) == 0);
  CHECK(map.read(1, 0x1021) == 1);
  CHECK(map.write(1, kOutput, 1000) == Refusal::kFailure);
  CHECK(map.write(1, 0x1121, 0xAFFE) == Refusal::kNone);  // the second word alone does nothing
  CHECK(map.write(1, kOutput, 1000) == Refusal::kFailure);
  CHECK(map.write(1, 0x1121, 0xBECF) == Refusal::kNone);
  CHECK(map.write(1, 0x1121, 0xAFFE) == Refusal::kNone);
  CHECK(map.write(1, kOutput, 1000) == Refusal::kNone);
  map.clock.wait_until(2h);
  CHECK(map.read(1, 0x1021) == 2);
}

TEST_CASE("module registers: type 1 is fed by readings of process data, type 2 is off") {
  Map map;
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  for (int i = 1; i <= 10; ++i) {
    map.clock.wait_until(i * 900ms);
    CHECK(map.read(1, 0) >= 0);
  }
  CHECK(map.chamber.output() > Volts(0.0));
  map.clock.wait_until(9900ms);
  CHECK(map.read(1, 0x1021) == 0);  // a register outside the process data does not feed
  map.clock.wait_until(10s);
  CHECK(map.read(1, 0x1021) == 1);

  Map off;
  REQUIRE(off.write(1, 0x1122, 2) == Refusal::kNone);
  REQUIRE(off.write(1, kOutput, 1000) == Refusal::kNone);
  off.clock.wait_until(24h);
  CHECK(off.chamber.output() > Volts(0.0));
  CHECK(off.read(1, 0x1021) == 0);
}

TEST_CASE("module registers: freeze holds the output") {
  Map map;
  REQUIRE(map.write(1, 0x1123, 1) == Refusal::kNone);
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  map.clock.wait_until(5s);
  CHECK(map.read(1, 0x1021) == 1);
  CHECK(map.read(1, kOutput) == 1000);
  CHECK(map.chamber.output() > Volts(0.0));
}

TEST_CASE("module registers: the write lock keeps others out until its holder hangs up") {
  Map map;
  map.registers.connected();
  map.registers.connected();
  CHECK(map.read(1, 0x1022) == 2);
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  CHECK(map.write(2, kOutput, 2000) == Refusal::kFailure);
  CHECK(map.read(2, kOutput) == 1000);
  map.registers.disconnected(1);
  CHECK(map.write(2, kOutput, 2000) == Refusal::kNone);
  CHECK(map.read(2, 0x1022) == 1);
}

TEST_CASE("module registers: without the lock others write, but only the first writer feeds") {
  Map map;
  REQUIRE(map.write(1, 0x1124, 0) == Refusal::kNone);
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  map.clock.wait_until(900ms);
  CHECK(map.write(2, kOutput, 2000) == Refusal::kNone);
  CHECK(map.chamber.output().value() == Approx(10.0 * 2000 / 0x7FFF));
  map.clock.wait_until(1s);
  CHECK(map.chamber.output() == Volts(0.0));
  CHECK(map.read(1, 0x1021) == 1);
}

TEST_CASE("module registers: a changed watchdog time counts from the change") {
  Map map;
  REQUIRE(map.write(1, kOutput, 1000) == Refusal::kNone);
  map.clock.wait_until(500ms);
  REQUIRE(map.write(1, 0x1120, 200) == Refusal::kNone);
  map.clock.wait_until(699ms);
  CHECK(map.chamber.output() > Volts(0.0));
  map.clock.wait_until(700ms);
  CHECK(map.chamber.output() == Volts(0.0));
}
