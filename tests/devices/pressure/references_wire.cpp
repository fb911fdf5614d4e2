// Pressure references and the regulator over a module that notes each request.
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>

#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/recorded_module.h"
#include "tests/devices/scripted_line.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using Notes = RecordedModule::Notes;

struct ReferenceRig {
  RecordedModule server;
  ManualClock clock;
  ModbusLink link{server.endpoint(), "gauge", clock};
};

}  // namespace

TEST_CASE("quantity: is read with its function code, address, format and scale") {
  ReferenceRig rig;
  rig.server.set(0x30, {0x4020, 0, 0xFFFE});  // 2.5, and -2
  const ModbusQuantity floating{4, 0x30, 5, {RegisterType::kF32, false}, {0, 1, 10, 30}};
  const RegisterValue psi = read_quantity(rig.link, floating);
  CHECK(psi.value == Approx(60.0));
  CHECK(psi.counts == 0x40200000);
  const ModbusQuantity word{3, 0x32, 0, {RegisterType::kI16, false}, {0, 100, 0, 50}};
  CHECK(read_quantity(rig.link, word).value == Approx(-1.0));
  CHECK(rig.server.notes() == Notes{"4 0030 2", "3 0032 1"});
}

TEST_CASE("quantity: a float that is not finite is a fault that names its register") {
  for (const std::uint16_t high : {std::uint16_t{0x7FC0}, std::uint16_t{0x7F80}, std::uint16_t{0xFF80}}) {
    ReferenceRig rig;
    rig.server.set(0x30, {high, 0});
    check_fault(
        [&] {
          (void)read_quantity(rig.link, {4, 0x30, 0, {RegisterType::kF32, false}, {0, 1, 0, 1}});
        },
        "TB-MODBUS-VALUE", {}, "0x0030");
  }
}

namespace {

// How many registers were asked for, request by request, of a line whose registers are all 5.
std::vector<int> counts_asked(const std::function<void(const ModbusEndpoint& line)>& talk) {
  std::vector<int> counts;
  auto line = std::make_unique<ScriptedLine>([&](int, const Bytes& request) {
    counts.push_back(request[5]);
    return rtu_reading(1, request[1], request[5], 5);
  });
  talk(rtu_endpoint(line->path(), 1));
  line.reset();  // with its thread, which wrote the counts
  return counts;
}

}  // namespace

TEST_CASE("modbus rtu: successive readings alternate in length by one spare register, if the map has one") {
  using AskedCounts = std::vector<int>;
  ManualClock clock;
  for (const int spare : {0, 1, 2}) {
    CHECK(counts_asked([&](const ModbusEndpoint& line) {
            ModbusLink link(line, "gauge", clock);
            for (const int function : {3, 4, 3, 4})
              CHECK(read_quantity(link, {function, 0, spare, {RegisterType::kU16, false}, {0, 1, 0, 1}}).value == 5.0);
          }) == (spare == 0 ? AskedCounts{1, 1, 1, 1} : AskedCounts{1, 2, 1, 2}));
    for (const int function : {3, 4}) {
      ModuleProfile profile;
      profile.inputs.function = function;
      profile.inputs.channels = 2;
      profile.inputs.spare = spare;
      CHECK(counts_asked([&](const ModbusEndpoint& line) {
              AnalogModule module(profile, line, 0ns, clock, Origin::kSimulated);
              for (int i = 0; i < 3; ++i) {
                module.forget_image();
                module.refresh();
              }
            }) == (spare == 0 ? AskedCounts{2, 2, 2} : AskedCounts{2, 3, 2}));
    }
  }
}

TEST_CASE("gauge: a reading has pressure, counts and time, and is corrected by its certificate") {
  ReferenceRig rig;
  rig.server.set(0x30, {400});
  GaugeOptions options;
  options.model = "gauge";
  options.serial = "G1";
  options.origin = Origin::kSimulated;
  options.quantity = {4, 0x30, 0, {RegisterType::kU16, false}, {0, 1000, 0, 100}};
  rig.clock.wait_until(7ms);
  auto gauge = std::make_unique<ModbusGauge>(std::make_unique<ModbusLink>(rig.server.endpoint(), "gauge", rig.clock),
                                             options, rig.clock);
  const PressureReading reading = gauge->read();
  CHECK(reading.pressure.value() == Approx(40.0));
  CHECK(reading.voltage == Volts(0.0));
  CHECK(reading.counts == 400);
  CHECK(reading.time == 7ms);
  CHECK(gauge->link().exchanges() == 1);
  CHECK(gauge->identity().role == "pressure reference");
  CHECK(gauge->identity().serial == "G1");
  PressureCorrection correction;
  correction.reading_psi = {0.0, 80.0};
  correction.correction_psi = {0.0, 2.0};
  correction.expanded_uncertainty_psi = {0.0, 0.1};
  CorrectedReference corrected(std::move(gauge), correction);
  CHECK(corrected.read().pressure.value() == Approx(41.0));
  CHECK(corrected.read().counts == 400);
  CHECK(corrected.identity().model == "gauge");
}

TEST_CASE("regulator and transducer: share one input image, which a command or a vent invalidates") {
  ReferenceRig rig;
  ModuleProfile profile;
  profile.outputs.address = 0x10;
  profile.outputs.channels = 2;
  profile.outputs.volts = {0, 1000, 0, 10};
  profile.inputs.address = 0x20;
  profile.inputs.channels = 3;
  profile.inputs.volts = {0, 1000, 0, 10};
  AnalogModule output(profile, rig.server.endpoint(), 0ns, rig.clock, Origin::kSimulated);
  AnalogModule input(profile, rig.server.endpoint(), 0ns, rig.clock, Origin::kSimulated);
  RegulatorOptions options;
  options.output_channel = 1;
  options.feedback_channel = 2;
  options.command_span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(100.0)};
  options.feedback_span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(200.0)};
  Regulator regulator(output, input, options, rig.clock);
  TransducerOptions other;
  other.channel = 1;
  other.span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(50.0)};
  ModuleTransducer transducer(input, other);
  regulator.arm();
  rig.server.set(0x20, {100, 200, 300});
  (void)rig.server.notes();
  const auto feedback = regulator.feedback();
  CHECK(feedback.pressure.value() == Approx(60.0));
  CHECK(feedback.voltage.value() == Approx(3.0));
  CHECK(feedback.counts == 300);
  const auto reference = transducer.read();
  CHECK(reference.pressure.value() == Approx(10.0));
  CHECK(reference.counts == 200);
  CHECK(rig.server.notes() == Notes{"4 0020 3"});
  rig.clock.wait_until(500us);
  (void)transducer.read();
  CHECK(rig.server.notes().empty());
  rig.clock.wait_until(500'001ns);
  (void)transducer.read();
  CHECK(rig.server.notes() == Notes{"4 0020 3"});
  CHECK(regulator.command(Psi(40.0)) == 400);
  CHECK(rig.server.notes() == Notes{"16 0010 <0 <400", "4 0020 3", "3 0010 2"});
  (void)regulator.feedback();
  (void)regulator.feedback();
  CHECK(rig.server.notes() == Notes{"4 0020 3"});
  CHECK(regulator.vent());
  (void)rig.server.notes();
  (void)transducer.read();
  CHECK(rig.server.notes() == Notes{"4 0020 3"});
}

TEST_CASE("regulator: keep_alive writes again after the feed interval, and only reads in between") {
  ReferenceRig rig;
  ModuleProfile profile;
  profile.outputs.channels = 1;
  profile.outputs.volts = {0, 1000, 0, 10};
  profile.inputs.address = 0x20;
  profile.inputs.channels = 1;
  AnalogModule module(profile, rig.server.endpoint(), 0ns, rig.clock, Origin::kSimulated);
  RegulatorOptions options;
  options.command_span.high = options.feedback_span.high = Psi(100.0);
  options.feed_interval = 300ms;
  Regulator regulator(module, module, options, rig.clock);
  regulator.arm();
  (void)rig.server.notes();
  regulator.keep_alive();  // nothing has been written yet
  CHECK(rig.server.notes() == Notes{"16 0000 <0", "4 0020 1", "3 0000 1"});
  CHECK(regulator.last_fed() == 0ns);
  rig.clock.wait_until(300ms - 1ns);
  regulator.keep_alive();
  CHECK(rig.server.notes() == Notes{"4 0020 1"});
  rig.clock.wait_until(300ms);
  regulator.keep_alive();
  CHECK(rig.server.notes() == Notes{"3 0000 1", "16 0000 <0", "4 0020 1"});
  regulator.disarm();
  CHECK_FALSE(regulator.armed());
  rig.clock.wait_until(900ms);
  regulator.keep_alive();
  CHECK(rig.server.notes() == Notes{"4 0020 1"});
  CHECK(fault_id_of([&] { regulator.command(Psi(1.0)); }) == "TB-CHAMBER-NOT-ARMED");
  regulator.arm();
  rig.server.interfere([](const std::string&) { return 4; });
  CHECK(fault_id_of([&] { regulator.command(Psi(1.0)); }) == "TB-MODBUS-EXCEPTION");
  CHECK_FALSE(regulator.armed());
}

TEST_CASE("regulator: reports a vent as done only if both output and valve obeyed") {
  ModuleProfile profile;
  profile.outputs.channels = 1;
  profile.inputs.channels = 1;
  profile.dump_coil = 4;
  const struct {
    std::string refused;
    bool done;
  } cases[] = {{"none", true}, {"5 0004 <0", false}, {"3 0000 1", false}};
  for (const auto& [refused, done] : cases) {
    INFO(refused);
    ReferenceRig rig;
    AnalogModule module(profile, rig.server.endpoint(), 0ns, rig.clock, Origin::kSimulated);
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = Psi(100.0);
    Regulator regulator(module, module, options, rig.clock);
    rig.server.interfere(
        [refused = refused](const std::string& note) { return note == refused ? std::optional(4) : std::nullopt; });
    CHECK(regulator.vent() == done);
    const Notes notes = rig.server.notes();
    CHECK(std::find(notes.begin(), notes.end(), "5 0004 <0") != notes.end());  // tried in any case
  }
}

namespace {

ModuleProfile with_valve() {
  ModuleProfile profile = module_profile("beckhoff-ek9000");
  profile.dump_coil = 3;
  return profile;
}

struct DumpValveRig {
  DumpValveRig()
      : server(with_valve(), 0, chamber, clock),
        module(with_valve(), {"127.0.0.1", server.port(), 1, kPatient}, 1000ms, clock, Origin::kSimulated),
        regulator(module, module, options(), clock) {}
  static RegulatorOptions options() {
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    return options;
  }
  ManualClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
  AnalogModule module;
  Regulator regulator;
};

}  // namespace

TEST_CASE("dump valve: is open until arming and after a vent, and closes at the next pressure above 0") {
  DumpValveRig rig;
  CHECK(rig.chamber.dumping);  // without power
  rig.regulator.arm();
  CHECK_FALSE(rig.chamber.dumping);
  (void)rig.regulator.command(Psi(5.0));
  CHECK(rig.regulator.vent());
  CHECK(rig.chamber.dumping);
  (void)rig.regulator.command(Psi(0.0));
  CHECK(rig.chamber.dumping);
  (void)rig.regulator.command(Psi(5.0));
  CHECK_FALSE(rig.chamber.dumping);
}

TEST_CASE("analog module: sends the dump valve's coil once to close, and at most twice to open") {
  ModuleProfile profile;
  profile.inputs.channels = 0;
  for (const int coil : {0, 9}) {
    profile.dump_coil = coil;
    const std::string note = coil == 0 ? "5 0000" : "5 0009";
    RecordedModule server;
    ManualClock clock;
    AnalogModule module(profile, server.endpoint(), 0ns, clock, Origin::kSimulated);
    module.close_dump();
    module.close_dump();
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280"});
    CHECK(module.open_dump());
    CHECK(server.notes() == RecordedModule::Notes{note + " <0"});
    server.interfere([](const std::string&) { return 4; });
    CHECK(fault_id_of([&] { module.close_dump(); }) == "TB-MODBUS-EXCEPTION");
    CHECK(server.connections() == 1);
    CHECK_FALSE(module.open_dump());
    CHECK(server.connections() == 2);  // the second attempt is made on a new one
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280", note + " <0", note + " <0"});
    std::atomic<int> left = 1;
    server.interfere([&](const std::string&) { return left-- > 0 ? std::optional(0) : std::nullopt; });
    CHECK(module.open_dump());
    CHECK(server.notes().size() == 2);
    module.close_dump();  // a failed order to close has not made it closed
    CHECK(server.notes() == RecordedModule::Notes{note + " <65280"});
  }
  profile.dump_coil = -1;
  RecordedModule none;
  ManualClock clock;
  AnalogModule module(profile, none.endpoint(), 0ns, clock, Origin::kSimulated);
  module.close_dump();
  CHECK(module.open_dump());
  CHECK(none.notes().empty());
}
