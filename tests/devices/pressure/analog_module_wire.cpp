#include <catch2/catch.hpp>

#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/recorded_module.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

namespace {

struct ModuleRig {
  explicit ModuleRig(SimulatedModuleFaults faults = {}, Nanoseconds timeout = kPatient)
      : server(std::make_unique<SimulatedModule>(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults)),
        module(module_profile("beckhoff-ek9000"), {"127.0.0.1", server->port(), 1, timeout}, 1000ms, clock,
               Origin::kSimulated),
        regulator(module, module, options(), clock) {}

  static RegulatorOptions options() {
    RegulatorOptions options;
    options.serial = "R1";
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    options.origin = Origin::kSimulated;
    return options;
  }

  ManualClock clock;
  TestChamber chamber{clock};
  std::unique_ptr<SimulatedModule> server;
  AnalogModule module;
  Regulator regulator;
};

}  // namespace

TEST_CASE("regulator: the watchdog keeps the output while fed, and zeroes it when not fed in time") {
  ModuleRig rig;
  rig.regulator.arm();
  rig.regulator.command(Psi(40.0));
  for (int i = 1; i <= 50; ++i) {
    rig.clock.wait_until(i * 400ms);
    rig.regulator.keep_alive();
  }
  CHECK(rig.regulator.feedback().pressure.value() == Approx(40.0).margin(0.003));
  rig.clock.wait_until(20s + 999ms);
  CHECK(rig.regulator.feedback().pressure.value() == Approx(40.0).margin(0.003));  // reading does not feed
  rig.clock.wait_until(21s);
  CHECK(rig.regulator.feedback().pressure == Psi(0.0));
  check_fault([&] { rig.regulator.keep_alive(); }, "TB-MODULE-WATCHDOG", {}, "1000 ms");
  CHECK(rig.chamber.output() == Volts(0.0));
  CHECK(rig.regulator.vent());  // refused as a write, but all outputs read 0
  rig.regulator.arm();
  rig.regulator.command(Psi(10.0));
  CHECK(rig.regulator.feedback().pressure.value() == Approx(10.0).margin(0.003));
}

TEST_CASE("regulator: a watchdog that expired between arming and the first command is set up again") {
  const bool reads_first = GENERATE(true, false);
  ModuleRig rig;
  rig.regulator.arm();
  rig.regulator.command(Psi(40.0));
  CHECK(rig.regulator.vent());
  rig.regulator.arm();
  rig.clock.wait_until(5s);  // other instruments take their time to open
  if (reads_first) CHECK(fault_id_of([&] { rig.regulator.keep_alive(); }) == "none");
  CHECK(fault_id_of([&] { rig.regulator.command(Psi(10.0)); }) == "none");
  CHECK(rig.regulator.feedback().pressure.value() == Approx(10.0).margin(0.003));
  rig.clock.wait_until(6s);  // it watches again
  CHECK(rig.regulator.feedback().pressure == Psi(0.0));
  CHECK(fault_id_of([&] { rig.regulator.keep_alive(); }) == "TB-MODULE-WATCHDOG");
}

namespace {

using Notes = RecordedModule::Notes;

ModuleProfile watched_profile(int watchdog_address = 0x1120, int fallbacks_address = 0x1021) {
  ModuleProfile profile;
  profile.outputs.address = 0x10;
  profile.outputs.channels = 2;
  profile.inputs.channels = 0;
  profile.fail_safe.watchdog_address = watchdog_address;
  profile.fail_safe.fallbacks_address = fallbacks_address;
  return profile;
}

struct BringUp {
  explicit BringUp(const ModuleProfile& profile, Nanoseconds watchdog = 0ns)
      : module(profile, server.endpoint(), watchdog, clock, Origin::kSimulated) {}
  RecordedModule server;
  ManualClock clock;
  AnalogModule module;
};

}  // namespace

TEST_CASE(
    "module bring-up: writes reset words, write lock, type and time of the watchdog, and reads the settings back") {
  BringUp rig(watched_profile(), 1500ms);
  rig.module.bring_up();
  CHECK(rig.server.notes() == Notes{"16 1121 <48847", "16 1121 <45054", "16 1124 <0", "3 1124 1", "16 1122 <0",
                                    "3 1122 1", "16 1120 <1500", "3 1120 1", "3 1021 1"});
  BringUp at_zero(watched_profile(0, 0x1021), 1ms);
  at_zero.module.bring_up();
  CHECK(at_zero.server.notes() == Notes{"16 0001 <48847", "16 0001 <45054", "16 0004 <0", "3 0004 1", "16 0002 <0",
                                        "3 0002 1", "16 0000 <1", "3 0000 1", "3 1021 1"});
  BringUp uncounted(watched_profile(0x1120, -1), 60s);
  uncounted.module.bring_up();
  CHECK(uncounted.server.notes().size() == 8);
  CHECK(uncounted.server.at(0x1120) == 60'000);
  BringUp counted(watched_profile(0x1120, 0), 1s);
  counted.module.bring_up();
  CHECK(counted.server.notes().back() == "3 0000 1");
  BringUp without(watched_profile(-1, -1));
  without.module.bring_up();
  CHECK(without.server.notes().empty());
}

TEST_CASE("module bring-up: refuses an unsupported watchdog time before anything is sent") {
  const struct {
    int address;
    Nanoseconds time;
    const char* milliseconds;
  } cases[] = {{0, 0ns, " 0 ms"},
               {0x1120, 0ns, " 0 ms"},
               {0x1120, 999us, " 0 ms"},
               {0x1120, 60'001ms, " 60001 ms"},
               {-1, 500ms, " 500 ms"}};  // it has none
  for (const auto& [address, time, milliseconds] : cases) {
    BringUp rig(watched_profile(address), time);
    check_fault([&] { rig.module.bring_up(); }, "TB-MODULE-WATCHDOG", "analog module", milliseconds);
    CHECK(rig.server.notes().empty());
  }
}

TEST_CASE("module bring-up: a setting that does not read back is a fault that names its register") {
  const struct {
    const char* note;
    std::size_t address;
    const char* told;
  } cases[] = {{"16 1124 <0", 0x1124, "0x1124"}, {"16 1122 <0", 0x1122, "0x1122"}, {"16 1120 <900", 0x1120, "0x1120"}};
  for (const auto& [note, address, told] : cases) {
    BringUp rig(watched_profile(), 900ms);
    rig.server.set(address, {7});
    rig.server.interfere([ignored = std::string(note)](const std::string& request) {
      return request == ignored ? std::optional(-1) : std::nullopt;
    });
    check_fault([&] { rig.module.bring_up(); }, "TB-MODULE-WATCHDOG", {}, told);
  }
}

TEST_CASE("module bring-up: if a channel is in safe mode, all are ordered out of it, and the result is checked") {
  ModuleProfile profile = watched_profile(-1, -1);
  profile.outputs.channels = 3;
  for (const bool at_zero : {false, true}) {
    profile.fail_safe.safe_mode_address = at_zero ? 0 : 0x40;
    profile.fail_safe.safe_mode_clear_address = 0x50;
    const std::size_t at = at_zero ? 0 : 0x40;
    const std::string look = at_zero ? "2 0000 3" : "2 0040 3";
    for (const std::size_t channel : {0, 1, 2}) {
      BringUp rig(profile);
      rig.server.set_inputs({at + channel});
      CHECK(fault_id_of([&] { rig.module.bring_up(); }) == "TB-MODULE-WATCHDOG");
      CHECK(rig.server.notes() == Notes{look, "5 0050 <65280", "5 0051 <65280", "5 0052 <65280", look});
    }
    BringUp rig(profile);
    rig.server.set_inputs({at + 3, at + 8});  // others' inputs
    rig.module.bring_up();
    CHECK(rig.server.notes() == Notes{look});
  }
}

TEST_CASE("module bring-up: closes the dump valve again, reads the inputs, and the next feed writes 0 V") {
  ModuleProfile profile = watched_profile(-1, -1);
  profile.inputs.address = 0x20;
  profile.inputs.channels = 1;
  profile.dump_coil = 3;
  BringUp rig(profile);
  rig.module.bring_up();
  CHECK(rig.server.notes() == Notes{"5 0003 <65280", "4 0020 1"});
  rig.module.write(1, 800);
  (void)rig.server.notes();
  rig.clock.wait_until(1s);
  rig.module.bring_up();
  CHECK(rig.server.notes() == Notes{"5 0003 <65280", "4 0020 1"});
  CHECK(rig.module.output(1) == 0);
  CHECK(rig.module.last_write_time() < 0ns);
  CHECK(rig.module.image_time() == 1s);
  rig.module.feed();
  CHECK(rig.server.notes() == Notes{"16 0010 <0 <0", "4 0020 1", "3 0010 2"});
}

TEST_CASE("module watchdog: a refused write or wrong read-back is a watchdog fault only if the watchdog has expired") {
  const struct {
    bool fallen;
    int refusal;  // 0: the connection breaks
    const char* id;
  } cases[] = {{true, 4, "TB-MODULE-WATCHDOG"}, {false, 4, "TB-MODBUS-EXCEPTION"}, {true, 0, "TB-MODBUS-CONNECT"}};
  for (const auto& [fallen, refusal, id] : cases) {
    BringUp rig(watched_profile(), 1s);
    rig.server.set(0x1021, {6});  // those of earlier runs
    rig.module.bring_up();
    rig.clock.wait_until(500ms);
    rig.module.write(0, 100);
    if (fallen) rig.server.set(0x1021, {7});
    rig.server.interfere([refusal = refusal](const std::string& note) {
      return note.starts_with("16") ? std::optional(refusal) : std::nullopt;
    });
    rig.clock.wait_until(2s);
    check_fault([&] { rig.module.write(0, 200); }, id, {},
                id == std::string("TB-MODULE-WATCHDOG") ? "1500 ms" : "");  // the age of the last write
  }
  // Found by reading the outputs back, too, and only there.
  for (const bool fallen : {true, false}) {
    BringUp rig(watched_profile(), 1s);
    rig.module.bring_up();
    rig.module.write(0, 100);
    rig.server.set(0x10, {0});
    if (fallen) rig.server.set(0x1021, {1});
    rig.clock.wait_until(1s);
    CHECK(fault_id_of([&] { rig.module.feed(); }) == (fallen ? "TB-MODULE-WATCHDOG" : "TB-MODULE-READBACK"));
  }
}

TEST_CASE("module watchdog: is set up again if it expired before the first write, another refusal is reported") {
  BringUp rig(watched_profile(), 1s);
  rig.module.bring_up();
  (void)rig.server.notes();
  rig.server.set(0x1021, {1});
  std::atomic<int> refusals = 1;
  rig.server.interfere([&](const std::string& note) {
    return note == "16 0010 <9 <0" && refusals-- > 0 ? std::optional(4) : std::nullopt;
  });
  rig.module.write(0, 9);
  CHECK(rig.server.notes() == Notes{"16 0010 <9 <0", "3 1021 1", "16 1121 <48847", "16 1121 <45054", "16 1124 <0",
                                    "3 1124 1", "16 1122 <0", "3 1122 1", "16 1120 <1000", "3 1120 1", "3 1021 1",
                                    "16 0010 <9 <0", "3 0010 2"});
  BringUp other(watched_profile(), 1s);
  other.module.bring_up();
  (void)other.server.notes();
  other.server.interfere([](const std::string& note) { return note[0] == '1' ? std::optional(2) : std::nullopt; });
  CHECK(fault_id_of([&] { other.module.write(0, 9); }) == "TB-MODBUS-EXCEPTION");
  CHECK(other.server.notes() == Notes{"16 0010 <9 <0", "3 1021 1"});
}

// Requests to an analog module, one by one, and the effect of each answer.

namespace {

using Notes = RecordedModule::Notes;
using WordsOut = std::vector<std::uint16_t>;

ModuleProfile plain_profile() {
  ModuleProfile profile;
  profile.model = "plain";
  profile.outputs.address = 0x10;
  profile.outputs.channels = 2;
  profile.outputs.volts = {0, 1000, 0, 10};
  profile.inputs.address = 0x20;
  profile.inputs.channels = 2;
  profile.inputs.volts = {0, 1000, 0, 10};
  return profile;
}

struct Requests {
  explicit Requests(const ModuleProfile& known = plain_profile()) : profile(known) {}
  RecordedModule server;
  ManualClock clock;
  ModuleProfile profile;
  AnalogModule module{profile, server.endpoint(), 0ns, clock, Origin::kSimulated};
};

}  // namespace

TEST_CASE("analog module: one request reads values and status words, by the profile's function code") {
  const struct {
    RegisterType type;
    int channels, status_offset, function;
    const char* note;
  } cases[] = {{RegisterType::kI16, 2, -1, 4, "4 0020 2"}, {RegisterType::kF32, 2, -1, 4, "4 0020 4"},
               {RegisterType::kI16, 2, 5, 3, "3 0020 7"},  {RegisterType::kF32, 3, 2, 4, "4 0020 6"},
               {RegisterType::kU32, 1, 2, 3, "3 0020 3"},  {RegisterType::kI16, 1, 0, 4, "4 0020 1"}};
  for (const auto& [type, channels, status_offset, function, note] : cases) {
    ModuleProfile profile = plain_profile();
    profile.inputs.format.type = type;
    profile.inputs.channels = channels;
    profile.inputs.status_offset = status_offset;
    profile.inputs.function = function;
    Requests rig(profile);
    rig.module.refresh();
    CHECK(rig.server.notes() == Notes{note});
  }
}

TEST_CASE("analog module: each channel has its own words, and other channel numbers are out of range") {
  ModuleProfile profile = plain_profile();
  profile.inputs.format.type = RegisterType::kI32;
  profile.inputs.channels = 3;
  Requests rig(profile);
  rig.server.set(0x20, {0, 1, 0xFFFF, 0xFFFE, 2, 3});
  rig.module.refresh();
  CHECK(rig.module.input(0).counts == 1);
  CHECK(rig.module.input(1).counts == -2);
  CHECK(rig.module.input(2).counts == 0x20003);
  CHECK(rig.module.input_volts(1).value() == Approx(-0.02));
  CHECK_THROWS_AS(rig.module.input(-1), std::out_of_range);
  CHECK_THROWS_AS(rig.module.input(3), std::out_of_range);
  CHECK_THROWS_AS(rig.module.output(2), std::out_of_range);
  CHECK_THROWS_AS(rig.module.write(2, 7), std::out_of_range);
  CHECK_THROWS_AS(rig.module.write(-1, 7), std::out_of_range);
}

TEST_CASE("analog module: the input image is read again if it is older than requested or was discarded") {
  Requests rig;
  const auto reads = [&](Nanoseconds max_age) {
    rig.module.refresh(max_age);
    return rig.server.notes().size();
  };
  CHECK(rig.module.image_time() < 0ns);
  CHECK(reads(1h) == 1);  // there is none yet
  CHECK(rig.module.image_time() == 0ns);
  CHECK(reads(0ns) == 0);  // of this very time
  rig.clock.wait_until(500us);
  CHECK(reads(500us) == 0);
  CHECK(reads(499'999ns) == 1);
  CHECK(rig.module.image_time() == 500us);
  rig.clock.wait_until(1ms);
  CHECK(reads(0ns) == 1);
  rig.module.forget_image();
  CHECK(reads(1h) == 1);
  rig.server.interfere([](const std::string&) { return 4; });
  rig.clock.wait_until(2ms);
  CHECK(fault_id_of([&] { rig.module.refresh(); }) == "TB-MODBUS-EXCEPTION");
  CHECK(rig.module.image_time() == 1ms);
  ModuleProfile outputs_only = plain_profile();
  outputs_only.inputs.channels = 0;
  Requests none(outputs_only);
  none.module.refresh();
  CHECK(none.server.notes().empty());
}

TEST_CASE("analog module: read_all reads inputs and outputs and writes nothing") {
  ModuleProfile profile = plain_profile();
  for (const int readback : {3, 4, 0}) {
    profile.outputs.readback = readback;
    Requests rig(profile);
    rig.server.set(0x10, {7, 8});
    CHECK(rig.module.read_all() == (readback == 0 ? WordsOut{} : WordsOut{7, 8}));
    CHECK(rig.server.notes() == (readback == 3   ? Notes{"4 0020 2", "3 0010 2"}
                                 : readback == 4 ? Notes{"4 0020 2", "4 0010 2"}
                                                 : Notes{"4 0020 2"}));
  }
  profile.outputs.readback = 3;
  profile.outputs.channels = 1;
  Requests one(profile);
  one.server.set(0x10, {7, 8});
  CHECK(one.module.read_all() == WordsOut{7});
  profile.outputs.channels = 0;
  Requests inputs_only(profile);
  CHECK(inputs_only.module.read_all().empty());
  CHECK(inputs_only.server.notes() == Notes{"4 0020 2"});
}

TEST_CASE("analog module: each function code writes all outputs, then reads the inputs and reads the outputs back") {
  const struct {
    int function;
    Notes notes;
  } cases[] = {{6, {"6 0010 <0", "6 0011 <77", "4 0020 2", "3 0010 2"}},
               {16, {"16 0010 <0 <77", "4 0020 2", "3 0010 2"}},
               {23, {"23 0020 2 0010 <0 <77", "3 0010 2"}}};
  for (const auto& [function, notes] : cases) {
    INFO("function " << function);
    ModuleProfile profile = plain_profile();
    profile.outputs.function = function;
    Requests rig(profile);
    rig.server.set(0x20, {5, 6});
    rig.clock.wait_until(3ms);
    rig.module.write(1, 77);
    CHECK(rig.server.notes() == notes);
    CHECK(rig.module.output(0) == 0);
    CHECK(rig.module.output(1) == 77);
    CHECK(rig.module.input(1).counts == 6);
    CHECK(rig.module.image_time() == 3ms);
    CHECK(rig.module.last_write_time() == 3ms);
  }
  ModuleProfile profile = plain_profile();
  profile.inputs.channels = 0;
  profile.outputs.readback = 0;
  Requests rig(profile);
  rig.module.write(0, 1);
  CHECK(rig.server.notes() == Notes{"16 0010 <1 <0"});
  CHECK(rig.module.image_time() < 0ns);
}

TEST_CASE("analog module: the first watchdog feed writes, later ones read the outputs back before they write again") {
  Requests rig;
  CHECK(rig.module.last_write_time() < 0ns);
  rig.module.feed();
  CHECK(rig.server.notes() == Notes{"16 0010 <0 <0", "4 0020 2", "3 0010 2"});
  rig.module.write(0, 500);
  (void)rig.server.notes();
  rig.clock.wait_until(1s);
  rig.module.feed();
  CHECK(rig.server.notes() == Notes{"3 0010 2", "16 0010 <500 <0", "4 0020 2"});
  CHECK(rig.module.last_write_time() == 1s);
  rig.server.set(0x11, {9});
  rig.clock.wait_until(2s);
  check_fault([&] { rig.module.feed(); }, "TB-MODULE-READBACK", {}, "500 9");
  CHECK(rig.server.notes() == Notes{"3 0010 2"});
  CHECK(rig.module.last_write_time() == 1s);
}

TEST_CASE("analog module: a value that was not read back is not used as the outputs' state") {
  Requests rig;
  rig.module.write(0, 500);
  rig.server.interfere([](const std::string& note) {
    return note.starts_with("16") ? std::optional(-1) : std::nullopt;  // acknowledged, and not done
  });
  rig.clock.wait_until(1s);
  CHECK(fault_id_of([&] { rig.module.write(0, 600); }) == "TB-MODULE-READBACK");
  CHECK(rig.module.output(0) == 500);
  rig.server.interfere(
      [](const std::string& note) { return note.starts_with("16") ? std::optional(4) : std::nullopt; });
  rig.clock.wait_until(2s);
  CHECK(fault_id_of([&] { rig.module.write(0, 700); }) == "TB-MODBUS-EXCEPTION");
  CHECK(rig.module.output(0) == 500);
  CHECK(rig.module.last_write_time() == 1s);
}

TEST_CASE("analog module: each relevant bit of a status word is a fault of one channel only") {
  ModuleProfile profile = plain_profile();
  profile.inputs.status_offset = 4;
  const struct {
    WordsOut words;
    std::array<std::string, 2> status;                             // that the channels' faults name
  } cases[] = {{{0, 0}, {"", ""}},       {{8, 0xFFF8}, {"", ""}},  // other bits mean something else
               {{1, 0}, {"0x0001", ""}}, {{0, 2}, {"", "0x0002"}},
               {{0, 4}, {"", "0x0004"}}, {{1, 0x108F}, {"0x0001", "0x108F"}}};
  for (const auto& [words, status] : cases) {
    Requests rig(profile);
    rig.server.set(0x24, words);
    CHECK_NOTHROW(rig.module.refresh());
    for (int channel = 0; channel < 2; ++channel) {
      const std::string& named = status[static_cast<std::size_t>(channel)];
      if (named.empty()) {
        CHECK_NOTHROW(rig.module.input(channel));
      } else {
        check_fault([&] { (void)rig.module.input(channel); }, "TB-MODULE-INPUT", {}, named);
        check_fault([&] { (void)rig.module.input_volts(channel); }, "TB-MODULE-INPUT", {},
                    "input " + std::to_string(channel));
      }
    }
  }
}

TEST_CASE("analog module: zero_outputs writes the counts of 0 V to all outputs, in at most two attempts") {
  ModuleProfile profile = plain_profile();
  profile.outputs.volts = {0, 4095, -10, 10};
  for (const int function : {6, 16, 23}) {
    INFO("function " << function);
    profile.outputs.function = function;
    Requests rig(profile);
    rig.clock.wait_until(3ms);
    CHECK(rig.module.zero_outputs());
    CHECK(rig.server.notes() == (function == 6 ? Notes{"6 0010 <2048", "6 0011 <2048", "3 0010 2"}
                                               : Notes{"16 0010 <2048 <2048", "3 0010 2"}));
    CHECK(rig.module.output(1) == 2048);
    CHECK(rig.module.last_write_time() == 3ms);
  }
  Requests rig;
  std::atomic<int> breaks = 0;
  rig.server.interfere([&](const std::string&) { return breaks-- > 0 ? std::optional(0) : std::nullopt; });
  for (const int times : {0, 1, 2}) {
    INFO(times << " broken connections");
    breaks = times;
    CHECK(rig.module.zero_outputs() == (times < 2));
    CHECK(rig.server.notes().size() == (times == 0 ? 2 : times == 1 ? 3 : 2));
  }
  // An output that rests elsewhere is put there by both.
  rig.module.rest_at(1, Volts(2.5));
  CHECK(rig.module.zero_outputs());
  CHECK(
      (rig.module.output(0) == 0 && rig.module.output(1) == rig.module.counts(Volts(2.5)) && rig.module.output(1) > 0));
  rig.module.bring_up();
  CHECK(rig.module.output(1) == rig.module.counts(Volts(2.5)));
  rig.module.rest_at(1, Volts(0.0));
  (void)rig.server.notes();
  // A refusal is no success by itself: what the outputs show decides.
  rig.server.interfere([](const std::string& note) { return note[0] == '1' ? std::optional(4) : std::nullopt; });
  rig.server.set(0x10, {0, 0});
  CHECK(rig.module.zero_outputs());
  CHECK(rig.server.notes().size() == 2);
  rig.server.set(0x10, {0, 1});
  CHECK_FALSE(rig.module.zero_outputs());
  CHECK(rig.server.notes().size() == 4);
  profile = plain_profile();
  profile.outputs.readback = 0;
  Requests blind(profile);
  blind.server.set(0x10, {5, 5});
  CHECK(blind.module.zero_outputs());
  CHECK(blind.server.notes() == Notes{"16 0010 <0 <0"});
  profile.outputs.channels = 0;
  Requests none(profile);
  CHECK_FALSE(none.module.zero_outputs());
  CHECK(none.server.notes().empty());
}

namespace {

// A slow output: it takes each write, but shows `first` for the first `stale` readings and what was written, plus
// `off`, from then on.
struct SlowOutput {
  SlowOutput(int stale, int off)
      : server([this, stale, off](int, int socket, const Bytes& request) {
          if (request[7] == 16) {
            written = request[13] * 256 + request[14];
            Bytes echo(request.begin(), request.begin() + 12);
            echo[4] = 0;
            echo[5] = 6;
            ScriptedServer::send(socket, echo);
          } else {
            const bool old = request[7] == 3 && readings++ < stale;
            ScriptedServer::send(
                socket, ScriptedServer::answer(request, {static_cast<std::uint16_t>(old ? 0 : written + off)}));
          }
        }),
        profile(module_profile("generic")) {
    profile.inputs.channels = 1;
  }
  std::atomic<int> readings{0};
  std::atomic<int> written{0};
  ScriptedServer server;
  ModuleProfile profile;
  ManualClock clock;
  std::string write() {
    AnalogModule module(profile, {"127.0.0.1", server.port(), 1, 20s}, 0s, clock, Origin::kSimulated);
    return fault_id_of([&] { module.write(0, 1000); });
  }
};

}  // namespace

TEST_CASE("read-back: another value is a fault, unless it is within the dead band") {
  SlowOutput exact(0, 0);
  CHECK(exact.write() == "none");
  SlowOutput off(0, 3);
  CHECK(off.write() == "TB-MODULE-READBACK");
  off.profile.outputs.dead_band = 2;
  CHECK(off.write() == "TB-MODULE-READBACK");
  off.profile.outputs.dead_band = 3;
  CHECK(off.write() == "none");
  CHECK(off.clock.now() == 0ns);
}

TEST_CASE("read-back: an output that follows late is waited for until the deadline") {
  SlowOutput late(3, 0);
  late.profile.outputs.deadline = 200ms;
  CHECK(late.write() == "none");
  CHECK(late.readings == 5);  // three stale, one that fits, one that decides
  CHECK(late.clock.now() == 60ms);
  SlowOutput never(1000, 0);
  never.profile.outputs.deadline = 200ms;
  CHECK(never.write() == "TB-MODULE-READBACK");
  CHECK(never.clock.now() == 200ms);
}
