#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/recorded_module.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

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
