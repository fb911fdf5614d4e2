// The simulated module's register map at the edges of its blocks: what a request may touch, what each register takes,
// what its inputs, quantities and outputs show.
#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "devices/pressure/module_registers.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Words = std::vector<std::uint16_t>;

struct MapUnit {
  explicit MapUnit(const SimulatedUnit& unit) : registers(unit, chamber, clock) {}
  explicit MapUnit(const ModuleProfile& profile) : MapUnit(SimulatedUnit{1, profile, {}}) {}
  std::optional<Words> read(int function, int address, std::size_t count) {
    Words words(count, 0xEEEE);
    if (registers.read(1, function, address, words) != Refusal::kNone) return std::nullopt;
    return words;
  }
  Refusal write(int address, const Words& words) { return registers.write(1, address, words); }
  ManualClock clock;
  TestChamber chamber{clock};
  ModuleRegisters registers;
};

// The registers from `from` on, `count` of them, can be read together and singly, none beside them in the same request.
void check_block(MapUnit& unit, int function, int from, int count) {
  INFO("function " << function << ", " << count << " from " << from);
  const auto size = static_cast<std::size_t>(count);
  const auto whole = unit.read(function, from, size);
  REQUIRE(whole);
  for (std::size_t i = 0; i < size; ++i) {
    const auto one = unit.read(function, from + static_cast<int>(i), 1);
    REQUIRE(one);
    CHECK(one->front() == whole->at(i));
  }
  CHECK_FALSE(unit.read(function, from - 1, 1));
  CHECK_FALSE(unit.read(function, from - 1, size));
  CHECK_FALSE(unit.read(function, from, size + 1));
  CHECK_FALSE(unit.read(function, from + 1, size));
  CHECK_FALSE(unit.read(function, from + count, 1));
}

ModuleProfile bare_profile() {
  ModuleProfile profile;
  profile.outputs.address = 0x100;
  profile.outputs.channels = 4;
  profile.outputs.volts = {0, 1000, 0, 10};
  return profile;
}

}  // namespace

TEST_CASE("module map: each block is read whole or in part, and no register outside it") {
  MapUnit beckhoff(module_profile("beckhoff-ek9000"));
  for (const int function : {3, 4}) check_block(beckhoff, function, 0x0000, 2);
  check_block(beckhoff, 3, 0x0800, 1);
  check_block(beckhoff, 3, 0x1120, 5);
  check_block(beckhoff, 3, 0x1020, 3);
  for (const int address : {0x0800, 0x1120, 0x1020}) CHECK_FALSE(beckhoff.read(4, address, 1));
  // Inputs, status words and spare registers are one block.
  ModuleProfile adam = module_profile("advantech-adam-6024");
  adam.inputs.spare = 3;
  MapUnit advantech(adam);
  check_block(advantech, 3, 0, 29);
  ModuleProfile shorter = bare_profile();
  shorter.inputs.channels = 4;
  shorter.inputs.format = {RegisterType::kF32, false};
  shorter.inputs.status_offset = 2;  // the values are longer
  MapUnit values(shorter);
  check_block(values, 4, 0, 8);
  shorter.inputs.status_offset = 0;
  MapUnit at_once(shorter);
  check_block(at_once, 4, 0, 8);
  ModuleProfile none = bare_profile();
  none.inputs.address = 0x200;
  none.inputs.status_offset = 2;
  MapUnit without(none);
  for (const int address : {0x1FF, 0x200, 0x201}) CHECK_FALSE(without.read(4, address, 1));
  check_block(without, 3, 0x100, 4);
}

TEST_CASE("module map: a watchdog at address 0 has its five registers there") {
  ModuleProfile profile = bare_profile();
  profile.fail_safe.watchdog_address = 0;
  MapUnit unit(profile);
  CHECK(unit.read(3, 0, 5) == Words{1000, 0, 1, 0, 1});
  CHECK(unit.write(0, {250}) == Refusal::kNone);
  CHECK(unit.write(5, {1}) == Refusal::kAddress);
  CHECK(unit.write(0x100, {500}) == Refusal::kNone);
  CHECK(unit.chamber.output() == Volts(5.0));
  unit.clock.wait_until(249ms);
  CHECK(unit.chamber.output() == Volts(5.0));
  unit.clock.wait_until(250ms);
  CHECK(unit.chamber.output() == Volts(0.0));
  unit.registers.turn();
  CHECK(unit.read(3, 0x100, 1) == Words{0});
  MapUnit without(bare_profile());
  CHECK_FALSE(without.read(3, 0, 1));
  CHECK(without.write(0, {250}) == Refusal::kAddress);
  CHECK(without.write(0x100, {500}) == Refusal::kNone);
  without.clock.wait_until(24h);
  without.registers.turn();
  CHECK(without.read(3, 0x100, 1) == Words{500});
  CHECK(without.chamber.output() == Volts(5.0));
}

TEST_CASE("module map: each watchdog setting accepts its valid values, refuses others, and reads back") {
  const struct {
    int offset;
    std::vector<std::uint16_t> taken, refused;
  } settings[] = {{0, {1, 2, 999, 59'999, 60'000}, {0, 60'001, 65'535}},
                  {2, {0, 1, 2}, {3, 4, 65'535}},
                  {3, {0, 1}, {2, 3, 65'535}},
                  {4, {0, 1}, {2, 3, 65'535}}};
  for (const auto& [offset, taken, refused] : settings) {
    MapUnit unit(module_profile("beckhoff-ek9000"));
    for (const std::uint16_t value : taken) {
      INFO("register " << offset << ", value " << value);
      CHECK(unit.write(0x1120 + offset, {value}) == Refusal::kNone);
      CHECK(unit.read(3, 0x1120 + offset, 1) == Words{value});
    }
    for (const std::uint16_t value : refused) {
      INFO("register " << offset << ", value " << value);
      CHECK(unit.write(0x1120 + offset, {value}) == Refusal::kValue);
      CHECK(unit.read(3, 0x1120 + offset, 1) == Words{taken.back()});
    }
    CHECK(unit.chamber.drives == 0);  // no output has been written
  }
  MapUnit unit(module_profile("beckhoff-ek9000"));
  CHECK(unit.write(0x1120, {700, 0, 2, 1, 0}) == Refusal::kNone);
  CHECK(unit.read(3, 0x1120, 5) == Words{700, 0, 2, 1, 0});
  CHECK(unit.write(0x1122, {0, 2, 1}) == Refusal::kValue);  // the third is not evaluated
  CHECK(unit.read(3, 0x1120, 5) == Words{700, 0, 0, 1, 0});
  CHECK(unit.write(0x1120, {700, 0, 2, 1, 0, 0}) == Refusal::kAddress);
  CHECK(unit.write(0x111F, {700, 0}) == Refusal::kAddress);
  CHECK(unit.write(0x1021, {0}) == Refusal::kAddress);
}

TEST_CASE("module map: inputs of two words show monitor and transducer on one channel each") {
  ModuleProfile profile = bare_profile();
  profile.inputs.channels = 4;
  profile.inputs.format = {RegisterType::kF32, false};
  profile.inputs.volts = {0, 10, 0, 10};
  profile.inputs.spare = 1;
  SimulatedUnit wired{1, profile, {}};
  wired.output_channel = 2;
  wired.feedback_channel = 1;
  wired.reference_channel = 3;
  MapUnit unit(wired);
  CHECK(unit.write(0x100, {100, 200, 250, 400}) == Refusal::kNone);
  CHECK(unit.chamber.output() == Volts(2.5));
  unit.chamber.reference_volts = Volts(-3.0);
  // 2.5 is 0x40200000, -3 is 0xC0400000.
  CHECK(unit.read(4, 0, 9) == Words{0, 0, 0x4020, 0, 0, 0, 0xC040, 0, 0});
  wired.profile.inputs.format.low_word_first = true;
  MapUnit swapped(wired);
  swapped.chamber.reference_volts = Volts(-3.0);
  CHECK(swapped.read(4, 6, 3) == Words{0, 0xC040, 0});
}

TEST_CASE("module map: registers after the last channel read 0, even if the wiring names such a channel") {
  ModuleProfile profile = bare_profile();
  profile.inputs.channels = 1;
  profile.inputs.spare = 2;
  for (const int reference : {1, 2}) {
    SimulatedUnit wired{1, profile, {}};
    wired.reference_channel = reference;
    MapUnit unit(wired);
    unit.chamber.reference_volts = Volts(5.0);
    CHECK(unit.write(0x100, {500}) == Refusal::kNone);
    CHECK(unit.read(4, 0, 3) == Words{16384, 0, 0});  // 5 V of 10 V for 32767 counts
  }
}

TEST_CASE("module map: an input is limited to full scale and to one count below negative full scale") {
  ModuleProfile profile = bare_profile();
  profile.inputs.channels = 2;
  profile.inputs.format = {RegisterType::kI32, false};
  profile.inputs.volts = {100, 1100, 0, 10};  // so that the span is not the full scale
  MapUnit unit(profile);
  const auto shows = [&](double volts) {
    unit.chamber.reference_volts = Volts(volts);
    const auto words = unit.read(4, 2, 2);
    REQUIRE(words);
    return decode_register(profile.inputs.format, *words).counts;
  };
  CHECK(shows(0.0) == 100);
  CHECK(shows(-9.0) == -800);
  CHECK(shows(-10.0) == -900);
  CHECK(shows(-10.01) == -901);
  CHECK(shows(-20.0) == -901);
  CHECK(shows(9.99) == 1099);
  CHECK(shows(10.0) == 1100);
  CHECK(shows(10.01) == 1100);
}

TEST_CASE("module map: quantities have their own function code, scale and spare registers") {
  SimulatedUnit instrument{1, bare_profile(), {}};
  instrument.quantities.push_back({{4, 0x30, 2, {RegisterType::kF32, false}, {0, 1, 0, 2}}, [] { return 5.0; }});
  instrument.quantities.push_back({{3, 0x40, 0, {RegisterType::kI16, false}, {0, 10, 0, 1}}, [] { return -2.5; }});
  instrument.quantities.push_back({{4, 0x40, 0, {RegisterType::kU16, false}, {0, 1, 0, 1}}, [] { return 7.0; }});
  MapUnit unit(instrument);
  check_block(unit, 4, 0x30, 4);
  CHECK(unit.read(4, 0x30, 4) == Words{0x4020, 0, 0, 0});  // 2.5
  CHECK_FALSE(unit.read(3, 0x30, 1));
  check_block(unit, 3, 0x40, 1);
  CHECK(unit.read(3, 0x40, 1) == Words{static_cast<std::uint16_t>(-25)});
  check_block(unit, 4, 0x40, 1);
  CHECK(unit.read(4, 0x40, 1) == Words{7});
  check_block(unit, 3, 0x100, 4);
}

TEST_CASE("module map: outputs are at 0 V at power-up if the scale includes it") {
  ModuleProfile profile = bare_profile();
  MapUnit plain(profile);
  CHECK(plain.read(3, 0x100, 4) == Words{0, 0, 0, 0});
  profile.outputs.volts = {0, 4095, -10, 10};
  MapUnit both_signs(profile);
  CHECK(both_signs.read(3, 0x100, 4) == Words{2048, 2048, 2048, 2048});  // 2047.5
  profile.outputs.volts = {0, 4095, 2, 10};
  MapUnit above(profile);
  CHECK(above.read(3, 0x100, 4) == Words{0, 0, 0, 0});  // it cannot give 0 V
}

TEST_CASE("module map: a negative word is 0 V if full scale is 15 bits, otherwise it is a large value") {
  ModuleProfile profile = bare_profile();
  const auto volts = [&](std::uint16_t word) {
    MapUnit unit(profile);
    CHECK(unit.write(0x100, {word}) == Refusal::kNone);
    CHECK(unit.read(3, 0x100, 1) == Words{word});
    return unit.chamber.output().value();
  };
  profile.outputs.volts = {0, 32767, 0, 10};
  CHECK(volts(1) == Approx(10.0 / 32767));
  CHECK(volts(0x4001) == Approx(10.0 * 0x4001 / 32767));
  CHECK(volts(0x7FFF) == Approx(10.0));
  CHECK(volts(0x8000) == 0.0);
  CHECK(volts(0xFFFF) == 0.0);
  profile.outputs.volts = {1, 32767, 1, 10};
  CHECK(volts(0x8000) == 0.0);
  profile.outputs.volts = {0, 32768, 0, 10};
  CHECK(volts(0x8000) == Approx(10.0));
  profile.outputs.volts = {0, 65535, 0, 10};
  CHECK(volts(0xFFFF) == Approx(10.0));
  profile.outputs.volts = {-1, 32767, -1, 32767};
  CHECK(volts(0x8000) == Approx(32768.0));
}

TEST_CASE("module map: registers have their power-up values, and writes to read-only or other addresses are refused") {
  MapUnit unit(module_profile("beckhoff-ek9000"));
  CHECK(unit.read(3, 0x1120, 5) == Words{1000, 0, 1, 0, 1});
  CHECK(unit.read(3, 0x1020, 3) == Words{0, 0, 0});
  CHECK(unit.read(3, 0x0800, 1) == Words{0});
  for (const int address : {0x0000, 0x0002, 0x07FF, 0x0801, 0x101F, 0x1020, 0x1023, 0x111F, 0x1125, 0xFFFF}) {
    INFO("address " << address);
    CHECK(unit.write(address, {1}) == Refusal::kAddress);
  }
}

namespace {

constexpr int kOutputWord = 0x0800;

struct FailSafeUnit : MapUnit {
  using MapUnit::MapUnit;
  FailSafeUnit() : MapUnit(module_profile("beckhoff-ek9000")) {}
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
};

}  // namespace

TEST_CASE("module watchdog: is reset only by 0xBECF followed directly by 0xAFFE") {
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

TEST_CASE("module watchdog: reports its remaining time while it runs") {
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

TEST_CASE("module watchdog: type 1 is fed when its master reads inputs or outputs, not when other clients do") {
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

TEST_CASE("module watchdog: a write feeds types 0 and 1, a reading does not feed type 0") {
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

TEST_CASE("module watchdog: a change of time, type or fallback restarts it, the lock and the reset words do not") {
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

TEST_CASE("module watchdog: the first write after a reset starts it, whichever client writes") {
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

TEST_CASE("module watchdog: the write lock belongs to its holder until that client disconnects") {
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

TEST_CASE("module watchdog: freeze keeps output and valve, fallback zeroes the output and opens the dump valve") {
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

TEST_CASE("module: each channel leaves safe mode by its own coil, and ignores writes until then") {
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

TEST_CASE("module watchdog: type 2 never expires, and the default type not before the first write") {
  FailSafeUnit off;
  CHECK(off.write(1, 0x1122, {2}) == Refusal::kNone);
  CHECK(off.write(1, kOutputWord, {1000}) == Refusal::kNone);
  CHECK(off.drives_at(24h));
  CHECK(off.read(1, 0x1021) == Words{0});
  FailSafeUnit unwritten;
  unwritten.clock.wait_until(1h);
  CHECK(unwritten.read(1, 0x1021) == Words{0});
}
