// The simulated module's fail-safe, order by order: who feeds its watchdog and what restarts it, the words that reset
// it, its dump valve's coil, and channels in safe mode.
#include <catch2/catch.hpp>
#include <vector>

#include "devices/pressure/module_registers.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Words = std::vector<std::uint16_t>;
constexpr int kOutputWord = 0x0800;

struct FailSafeUnit {
  explicit FailSafeUnit(const SimulatedUnit& unit) : registers(unit, chamber, clock) {}
  explicit FailSafeUnit(const ModuleProfile& profile = module_profile("beckhoff-ek9000"))
      : FailSafeUnit(SimulatedUnit{1, profile, {}}) {}
  Refusal write(int client, int address, const Words& words) {
    registers.turn();
    return registers.write(client, address, words);
  }
  Words read(int client, int address, std::size_t count = 1) {
    registers.turn();
    Words words(count, 0xEEEE);
    CHECK(registers.read(client, 3, address, words) == Refusal::kNone);
    return words;
  }
  // Whether the output drives at `time`.
  bool drives_at(Nanoseconds time) {
    clock.wait_until(time);
    return chamber.output() > Volts(0.0);
  }
  void trip() {
    CHECK(write(1, kOutputWord, {1000}) == Refusal::kNone);
    CHECK_FALSE(drives_at(clock.now() + 1s));
    CHECK(write(1, kOutputWord, {1000}) == Refusal::kFailure);
  }
  TurnedClock clock;
  TestChamber chamber{clock};
  ModuleRegisters registers;
};

}  // namespace

TEST_CASE("module watchdog: only 0xBECF and then 0xAFFE, one right after the other, reset it") {
  const struct {
    Words words;
    bool reset;
  } cases[] = {{{0xBECF, 0xAFFE}, true},
               {{0xBECF, 0xBECF, 0xAFFE}, true},
               {{0xBECF, 0xAFFE, 0xAFFE}, true},
               {{0xAFFE}, false},
               {{0xBECF}, false},
               {{0xAFFE, 0xBECF}, false},
               {{0xBECF, 0, 0xAFFE}, false},
               {{0xBECF, 0xAFFF}, false},
               {{0xBECF, 0xAFFD}, false},
               {{0xBECE, 0xAFFE}, false},
               {{0xBED0, 0xAFFE}, false},
               {{0xBECF, 0xAFFD, 0xAFFE}, false},
               {{0xBECF, 0xAFFE, 0xBECF}, true},
               {{0, 0}, false}};
  for (const auto& [words, reset] : cases) {
    FailSafeUnit unit;
    unit.trip();
    for (const std::uint16_t word : words) {
      INFO("word " << word);
      CHECK(unit.write(1, 0x1121, {word}) == Refusal::kNone);
      CHECK(unit.read(1, 0x1121) == Words{0});
    }
    CHECK(unit.write(1, kOutputWord, {1000}) == (reset ? Refusal::kNone : Refusal::kFailure));
    CHECK(unit.read(1, 0x1021) == Words{1});
  }
}

TEST_CASE("module watchdog: its time left is told while it runs") {
  FailSafeUnit unit;
  unit.registers.connected();
  unit.registers.connected();
  CHECK(unit.read(1, 0x1020, 3) == Words{0, 0, 2});
  CHECK(unit.write(1, kOutputWord, {1000}) == Refusal::kNone);
  unit.clock.wait_until(1ms);
  CHECK(unit.read(1, 0x1020, 3) == Words{999, 0, 2});
  CHECK(unit.write(1, 0x1122, {2}) == Refusal::kNone);
  CHECK(unit.read(1, 0x1020, 3) == Words{0, 0, 2});
  CHECK(unit.write(1, 0x1122, {1}) == Refusal::kNone);
  unit.clock.wait_until(1001ms);
  unit.registers.disconnected(1);
  CHECK(unit.read(1, 0x1020, 3) == Words{0, 1, 1});
}

TEST_CASE("module watchdog: type 1 is fed by its master's readings of inputs or outputs, by no other's") {
  for (const int address : {0x0000, 0x0001, kOutputWord}) {
    INFO("address " << address);
    FailSafeUnit unit;
    CHECK(unit.write(1, kOutputWord, {1000}) == Refusal::kNone);
    unit.clock.wait_until(600ms);
    (void)unit.read(1, address);
    CHECK(unit.drives_at(1599ms));
    (void)unit.read(2, address);
    CHECK_FALSE(unit.drives_at(1600ms));
    unit.registers.turn();
    (void)unit.read(1, address);  // what fell back is not fed any more
    CHECK_FALSE(unit.drives_at(1601ms));
  }
  FailSafeUnit unwritten;
  (void)unwritten.read(1, 0x0000);
  (void)unwritten.read(-1, 0x0000);  // before the first write there is nothing to feed
  CHECK(unwritten.chamber.drives == 0);
}

TEST_CASE("module watchdog: a write by type 0 and 1 feeds, a reading by type 0 does not") {
  for (const std::uint16_t type : {std::uint16_t{0}, std::uint16_t{1}}) {
    FailSafeUnit unit;
    CHECK(unit.write(1, 0x1122, {type}) == Refusal::kNone);
    CHECK(unit.write(1, kOutputWord, {1000}) == Refusal::kNone);
    unit.clock.wait_until(600ms);
    CHECK(unit.write(1, kOutputWord, {1000}) == Refusal::kNone);
    CHECK(unit.drives_at(1599ms));
    (void)unit.read(1, 0x0000);
    CHECK(unit.drives_at(1600ms) == (type == 1));
  }
}

TEST_CASE("module watchdog: a changed time, type or fallback restarts it, the lock and the reset words do not") {
  const struct {
    int address;
    std::uint16_t value;
    bool restarts;
  } cases[] = {{0x1120, 1000, true}, {0x1121, 0xBECF, false}, {0x1122, 0, true}, {0x1123, 0, true}, {0x1124, 0, false}};
  for (const auto& [address, value, restarts] : cases) {
    INFO("address " << address);
    FailSafeUnit unit;
    CHECK(unit.write(1, kOutputWord, {1000}) == Refusal::kNone);
    unit.clock.wait_until(500ms);
    CHECK(unit.write(1, address, {value}) == Refusal::kNone);
    CHECK(unit.drives_at(999ms));
    CHECK(unit.drives_at(1000ms) == restarts);
    CHECK(unit.drives_at(1499ms) == restarts);
    CHECK_FALSE(unit.drives_at(1500ms));
  }
}

TEST_CASE("module watchdog: the first write after a reset starts it, whoever writes") {
  FailSafeUnit unit;
  CHECK(unit.write(1, 0x1124, {0}) == Refusal::kNone);
  unit.trip();
  CHECK(unit.write(2, 0x1121, {0xBECF}) == Refusal::kNone);
  CHECK(unit.write(2, 0x1121, {0xAFFE}) == Refusal::kNone);
  unit.clock.wait_until(5s);
  CHECK(unit.write(2, kOutputWord, {1000}) == Refusal::kNone);
  CHECK(unit.drives_at(5s + 600ms));
  CHECK(unit.write(2, kOutputWord, {2000}) == Refusal::kNone);  // drives, but feeds no more: client 1 is the master
  CHECK(unit.chamber.output().value() == Approx(20000.0 / 32767));
  CHECK(unit.drives_at(5s + 999ms));
  CHECK_FALSE(unit.drives_at(6s));
}

TEST_CASE("module watchdog: the lock is its holder's, until that one hangs up") {
  FailSafeUnit unit;
  CHECK(unit.write(0, kOutputWord, {1000}) == Refusal::kNone);  // the first client has the number 0
  unit.registers.disconnected(3);
  CHECK(unit.write(3, kOutputWord, {2000}) == Refusal::kFailure);
  CHECK(unit.write(0, kOutputWord, {3000}) == Refusal::kNone);
  unit.registers.disconnected(0);
  CHECK(unit.write(3, kOutputWord, {2000}) == Refusal::kNone);
  CHECK(unit.write(0, kOutputWord, {3000}) == Refusal::kFailure);
  CHECK(unit.read(0, kOutputWord) == Words{2000});
}

TEST_CASE("module watchdog: freezing holds output and valve, falling back zeroes and dumps") {
  for (const bool freeze : {false, true}) {
    INFO("freeze " << freeze);
    ModuleProfile profile = module_profile("beckhoff-ek9000");
    profile.dump_coil = 0;
    profile.outputs.volts = {0, 4095, -10, 10};
    FailSafeUnit unit(profile);
    CHECK(unit.chamber.dumping);  // without power it is open
    CHECK(unit.registers.write_bit(0, true) == Refusal::kNone);
    CHECK_FALSE(unit.chamber.dumping);
    CHECK(unit.registers.write_bit(1, true) == Refusal::kAddress);
    CHECK(unit.write(1, 0x1123, {freeze ? std::uint16_t{1} : std::uint16_t{0}}) == Refusal::kNone);
    CHECK(unit.write(1, kOutputWord, {4095}) == Refusal::kNone);
    CHECK(unit.chamber.output() == Volts(10.0));
    unit.clock.wait_until(1s);
    CHECK(unit.chamber.output() == Volts(freeze ? 10.0 : 0.0));
    CHECK(unit.read(1, kOutputWord) == Words{freeze ? std::uint16_t{4095} : std::uint16_t{2048}});
    CHECK(unit.chamber.dumping == !freeze);
    CHECK(unit.registers.write_bit(0, true) == Refusal::kFailure);
    CHECK(unit.registers.write_bit(0, false) == Refusal::kFailure);
    CHECK(unit.chamber.dumping == !freeze);
  }
  FailSafeUnit without;
  CHECK_FALSE(without.chamber.dumping);
  CHECK(without.registers.write_bit(0, true) == Refusal::kAddress);
}

TEST_CASE("module: coils open and close the dump valve") {
  ModuleProfile profile = module_profile("generic");
  profile.dump_coil = 7;
  FailSafeUnit unit(profile);
  CHECK(unit.chamber.dumping);
  for (const bool closed : {true, false, true}) {
    CHECK(unit.registers.write_bit(7, closed) == Refusal::kNone);
    CHECK(unit.chamber.dumping == !closed);
  }
  for (const int coil : {0, 6, 8}) CHECK(unit.registers.write_bit(coil, false) == Refusal::kAddress);
  CHECK_FALSE(unit.chamber.dumping);
}

TEST_CASE("module: each channel leaves its safe mode by its own coil, and till then ignores what is written") {
  ModuleProfile profile = module_profile("moxa-iologik-e1241");
  const bool from_zero = GENERATE(false, true);
  if (from_zero) profile.fail_safe.safe_mode_address = profile.fail_safe.safe_mode_clear_address = 0;
  const int at = from_zero ? 0 : 0x1010;
  const int clear = from_zero ? 0 : 0x1020;
  FailSafeUnit unit(SimulatedUnit{1, profile, {}, true});
  const auto modes = [&](int address, std::size_t count) {
    std::vector<std::uint8_t> bits(count, 9);
    return unit.registers.read_bits(address, bits) == Refusal::kNone ? bits : std::vector<std::uint8_t>{};
  };
  using Bits = std::vector<std::uint8_t>;
  CHECK(modes(at, 4) == Bits{1, 1, 1, 1});
  CHECK(modes(at + 3, 1) == Bits{1});
  CHECK(modes(at - 1, 1).empty());
  CHECK(modes(at, 5).empty());
  CHECK(modes(at + 1, 4).empty());
  CHECK(modes(at + 4, 1).empty());
  CHECK(unit.registers.write_bit(clear + 2, false) == Refusal::kNone);  // only switching it on clears
  CHECK(modes(at, 4) == Bits{1, 1, 1, 1});
  CHECK(unit.registers.write_bit(clear + 2, true) == Refusal::kNone);
  CHECK(modes(at, 4) == Bits{1, 1, 0, 1});
  CHECK(modes(at + 2, 2) == Bits{0, 1});
  CHECK(unit.registers.write_bit(clear + 4, true) == Refusal::kAddress);
  if (!from_zero) CHECK(unit.registers.write_bit(clear - 1, true) == Refusal::kAddress);
  CHECK(unit.write(1, 0x0400, {11, 12, 13, 14}) == Refusal::kNone);
  CHECK(unit.read(1, 0x0400, 4) == Words{0, 0, 13, 0});
  CHECK(unit.write(1, 0x0402, {23, 24}) == Refusal::kNone);
  CHECK(unit.read(1, 0x0400, 4) == Words{0, 0, 23, 0});
  CHECK(unit.registers.write_bit(clear, true) == Refusal::kNone);
  CHECK(unit.registers.write_bit(clear + 3, true) == Refusal::kNone);
  CHECK(modes(at, 4) == Bits{0, 1, 0, 0});
  CHECK(unit.write(1, 0x0400, {31, 32, 33, 34}) == Refusal::kNone);
  CHECK(unit.read(1, 0x0400, 4) == Words{31, 0, 33, 34});
  FailSafeUnit usual(SimulatedUnit{1, profile, {}});
  std::vector<std::uint8_t> bits(4, 9);
  CHECK(usual.registers.read_bits(at, bits) == Refusal::kNone);
  CHECK(bits == Bits{0, 0, 0, 0});
  FailSafeUnit without(module_profile("generic"));
  CHECK(without.registers.read_bits(at, std::span(bits).first(1)) == Refusal::kAddress);
  CHECK(without.registers.write_bit(clear, true) == Refusal::kAddress);
}

TEST_CASE("module watchdog: type 2 never falls back, and none does before the first write") {
  FailSafeUnit off;
  CHECK(off.write(1, 0x1122, {2}) == Refusal::kNone);
  CHECK(off.write(1, kOutputWord, {1000}) == Refusal::kNone);
  CHECK(off.drives_at(24h));
  CHECK(off.read(1, 0x1021) == Words{0});
  FailSafeUnit unwritten;
  unwritten.clock.wait_until(1h);
  CHECK(unwritten.read(1, 0x1021) == Words{0});
}
