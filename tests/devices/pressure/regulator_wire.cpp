// The regulator behind its module joins the table of actuator laws; tests of its further promises.

#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <thread>

#include "devices/pressure/regulator.h"
#include "devices/pressure/serial_controller.h"
#include "devices/pressure/simulated_controller.h"
#include "devices/pressure/simulated_module.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/actuator_contract.h"
#include "tests/devices/pressure/next_fault.h"
#include "tests/devices/pressure/raw_clients.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

namespace {

struct RegulatorBed final : ActuatorBed {
  RegulatorBed(const BedOptions& options, const std::string& profile)
      : known(module_profile(profile)),
        server(new_server(0)),
        module(known, {"127.0.0.1", server->port(), 1, options.reply_timeout}, watchdog(), time, Origin::kSimulated),
        regulator(module, module, regulator_options(), time) {}
  static RegulatorOptions regulator_options() {
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    return options;
  }

  Regulator& actuator() override { return regulator; }
  ManualClock& clock() override { return time; }
  [[nodiscard]] std::string faults_begin_with() const override { return "TB-CHAMBER"; }
  void make_ready() override { regulator.arm(); }
  std::vector<Act> commands() override {
    return {[&] { regulator.command(Psi(20.0)); }, [&] { regulator.command(Psi(0.0)); }};
  }
  std::vector<Act> forbidden() override {
    std::vector<Act> all;
    for (const double psi : {60.0001, -0.0001, std::nan(""), HUGE_VAL, -HUGE_VAL})
      all.emplace_back([this, psi] { regulator.command(Psi(psi)); });
    return all;
  }
  void load() override { regulator.command(Psi(50.0)); }
  [[nodiscard]] bool make_safe() noexcept override { return regulator.vent(); }
  bool is_in_safe_state() override { return chamber.output() == Volts(0.0); }
  [[nodiscard]] std::uint64_t received() const override { return requests; }
  [[nodiscard]] std::uint64_t driven() const override { return static_cast<std::uint64_t>(chamber.drives); }
  void fall_silent() override { silent = true; }
  void break_wire() override {
    last_port = server->port();
    server.reset();
  }
  // On the same port; the output terminal keeps what it had.
  void mend_wire() override { server = new_server(last_port); }
  [[nodiscard]] int questions() const override { return 1; }
  [[nodiscard]] int questions_to_make_safe() const override { return 4; }  // two attempts of two

  [[nodiscard]] Nanoseconds watchdog() const { return known.fail_safe.watchdog_address >= 0 ? 1000ms : 0ms; }
  std::unique_ptr<SimulatedModule> new_server(int port) {
    SimulatedModuleFaults faults;
    faults.inject = [this] {
      ++requests;
      return silent ? InjectedFault::kSilent : InjectedFault::kNone;
    };
    return std::make_unique<SimulatedModule>(known, port, chamber, time, faults);
  }

  ModuleProfile known;
  ManualClock time;
  std::atomic<std::uint64_t> requests{0};
  std::atomic<bool> silent{false};
  int last_port = 0;
  TestChamber chamber{time};
  std::unique_ptr<SimulatedModule> server;
  AnalogModule module;
  Regulator regulator;
};

const char* const kProfiles[] = {"beckhoff-ek9000", "advantech-adam-6024", "generic"};
const JoinsActuatorLaws<Regulator, RegulatorBed> kBeckhoff("regulator, watchdog and FC 23", kProfiles[0]),
    kAdvantech("regulator, single words", kProfiles[1]), kGeneric("regulator, plain module", kProfiles[2]);

}  // namespace

TEST_CASE("regulator: reads without feeding while it is not armed") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    RegulatorBed bed({}, profile);
    bed.clock().wait_until(10s);
    bed.regulator.keep_alive();
    (void)bed.regulator.feedback();
    CHECK(bed.received() > 0);
    CHECK(bed.chamber.drives == 0);
  }
}

TEST_CASE("regulator: after a restored connection and arming, the first feed writes 0 V") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    RegulatorBed bed({}, profile);
    bed.regulator.arm();
    bed.regulator.command(Psi(50.0));
    REQUIRE(bed.chamber.output() > Volts(3.8));
    bed.break_wire();
    bed.mend_wire();
    bed.clock().wait_until(500ms);
    CHECK(fault_id_of([&] { bed.regulator.keep_alive(); }) != "none");
    CHECK_FALSE(bed.regulator.armed());
    const int drives = bed.chamber.drives;
    bed.regulator.keep_alive();
    (void)bed.regulator.feedback();
    CHECK(bed.chamber.drives == drives);
    bed.regulator.arm();
    bed.regulator.keep_alive();
    CHECK(bed.chamber.output() == Volts(0.0));
  }
}

TEST_CASE("module: arming takes a channel out of safe mode, and the next command takes effect") {
  ManualClock clock;
  TestChamber chamber(clock);
  const ModuleProfile outputs = module_profile("moxa-iologik-e1241");
  const ModuleProfile inputs = module_profile("moxa-iologik-e1240");
  SimulatedUnit out{1, outputs, {}, true};
  SimulatedModule server({out, {2, inputs, {}}}, SimulatedModule::Wire::kTcp, 0, chamber, clock);
  AnalogModule output(outputs, {"127.0.0.1", server.port(), 1, kPatient}, 0s, clock, Origin::kSimulated);
  AnalogModule input(inputs, output, 2, clock, Origin::kSimulated);
  Regulator regulator(output, input, RegulatorBed::regulator_options(), clock);
  CHECK(fault_id_of([&] { output.write(0, 100); }) == "TB-MODULE-READBACK");  // safe mode ignores it
  regulator.arm();
  regulator.command(Psi(30.0));
  CHECK(regulator.feedback().pressure.value() == Approx(30.0).margin(0.05));
}

// The serial pressure controller joins the table of actuator laws; tests of its further promises, against its simulated
// end on a pseudo-terminal.

namespace {

SerialControllerOptions with(Nanoseconds reply_timeout, bool exhausts) {
  SerialControllerOptions options;
  options.reply_timeout = reply_timeout;
  options.exhausts = exhausts;
  return options;
}

RegulatorOptions regulator_options() {
  RegulatorOptions options;
  options.command_span.high = Psi(100.0);
  options.origin = Origin::kSimulated;
  return options;
}

struct ControllerBed final : ActuatorBed {
  ControllerBed(const BedOptions& bed, bool exhausts)
      : options(with(bed.reply_timeout, exhausts)),
        server(options, Psi(100.0), chamber, [this] { return times-- > 0 ? fault.load() : InjectedFault::kNone; }),
        controller([this] { return open_stream(server.path()); }, regulator_options(), options, time) {}
  SerialController& actuator() override { return controller; }
  ManualClock& clock() override { return time; }
  [[nodiscard]] std::string faults_begin_with() const override { return "TB-CHAMBER"; }
  void make_ready() override { controller.arm(); }
  std::vector<Act> commands() override {
    return {[&] { controller.command(Psi(20.0)); }, [&] { controller.command(Psi(0.0)); }};
  }
  std::vector<Act> forbidden() override {
    std::vector<Act> all;
    for (const double psi : {60.0001, -0.0001, std::nan(""), HUGE_VAL, -HUGE_VAL})
      all.emplace_back([this, psi] { controller.command(Psi(psi)); });
    return all;
  }
  void load() override { controller.command(Psi(50.0)); }
  [[nodiscard]] bool make_safe() noexcept override { return controller.vent(); }
  bool is_in_safe_state() override { return chamber.output() == Volts(0.0); }
  [[nodiscard]] std::uint64_t received() const override { return server.requests(); }
  [[nodiscard]] std::uint64_t driven() const override { return static_cast<std::uint64_t>(chamber.drives); }
  void fall_silent() override { spoil(InjectedFault::kSilent, 1000); }
  void break_wire() override { server.unplug(); }
  void mend_wire() override { server.plug_in(); }
  [[nodiscard]] int questions() const override { return 1; }
  [[nodiscard]] int questions_to_make_safe() const override { return 4; }  // two attempts of two

  void spoil(InjectedFault how, int often) {
    fault = how;
    times = often;
  }

  SerialControllerOptions options;
  ManualClock time;
  TestChamber chamber{time};
  std::atomic<int> times{0};
  std::atomic<InjectedFault> fault{InjectedFault::kNone};
  SimulatedController server;
  SerialController controller;
};

const JoinsActuatorLaws<SerialController, ControllerBed> kExhausting("serial controller with an exhaust valve", true),
    kPlain("serial controller without an exhaust valve", false);

}  // namespace

TEST_CASE("serial controller: a set-point is read back and drives the chamber, and the feedback is its own") {
  ControllerBed bed({}, true);
  bed.controller.arm();
  CHECK(bed.controller.command(Psi(12.346)) == 1235);
  CHECK(bed.chamber.output().value() == Approx(1.235));
  const PressureReading reading = bed.controller.feedback();
  CHECK(reading.pressure.value() == Approx(12.35).margin(0.006));
  CHECK(bed.controller.exchanges() == 2);  // the answer to the set-point was the reading
  bed.clock().wait_until(1s);
  CHECK(bed.controller.feedback().time == Nanoseconds(1s));
  CHECK(bed.controller.exchanges() == 3);
}

TEST_CASE("serial controller: a vent opens the exhaust where there is one, and the next load closes it") {
  for (const bool exhausts : {true, false}) {
    INFO(exhausts);
    ControllerBed bed({}, exhausts);
    bed.make_ready();
    bed.load();
    CHECK_FALSE(bed.chamber.dumping);
    CHECK(bed.controller.vent());
    CHECK(bed.chamber.dumping == exhausts);
    bed.controller.keep_alive();
    CHECK(bed.controller.command(Psi(0.0)) == 0);
    CHECK(bed.chamber.dumping == exhausts);
    bed.load();
    CHECK_FALSE(bed.chamber.dumping);
    CHECK(bed.chamber.output().value() == Approx(5.0));
  }
}

TEST_CASE("serial controller: each damaged answer has its own fault, disarms, and the chamber is then vented") {
  const auto [how, id] = GENERATE(table<InjectedFault, std::string>({
      {InjectedFault::kSilent, "TB-CONTROLLER-TIMEOUT"},
      {InjectedFault::kLate, "TB-CONTROLLER-TIMEOUT"},
      {InjectedFault::kCorrupt, "TB-CONTROLLER-PROTOCOL"},
      {InjectedFault::kRefused, "TB-CONTROLLER-REFUSED"},
      {InjectedFault::kUnplugged, "TB-SERIAL-LOST"},
  }));
  ControllerBed bed({300ms, 2s}, true);
  bed.make_ready();
  bed.load();
  bed.spoil(how, 1);
  CHECK(fault_id_of([&] { bed.controller.command(Psi(20.0)); }) == id);
  CHECK_FALSE(bed.controller.armed());
  if (how == InjectedFault::kUnplugged) bed.mend_wire();
  CHECK(bed.controller.vent());
  CHECK(bed.is_in_safe_state());
  CHECK(bed.chamber.dumping);
  CHECK(fault_id_of([&] { (void)bed.controller.feedback(); }) == "none");
}

TEST_CASE("serial controller: feeding finds a set-point that another program has written, and writes nothing over it") {
  ControllerBed bed({}, true);
  bed.make_ready();
  bed.load();
  bed.clock().wait_until(1s);
  bed.controller.keep_alive();  // its set-point is unchanged
  CHECK(bed.controller.last_fed() == Nanoseconds(1s));
  const auto other = open_stream(bed.server.path(), 2s, false);
  const std::string line = "AS30\r";
  const std::uint64_t before = bed.received();
  other->write(std::span(reinterpret_cast<const std::uint8_t*>(line.data()), line.size()));
  while (bed.received() == before) std::this_thread::yield();
  std::array<std::uint8_t, 64> answer{};
  (void)other->read(answer, kPatient);
  bed.clock().wait_until(2s);
  check_fault([&] { bed.controller.keep_alive(); }, "TB-CONTROLLER-READBACK", "regulator", "30");
  CHECK_FALSE(bed.controller.armed());
  CHECK(bed.chamber.output().value() == Approx(3.0));
}

TEST_CASE("serial controller: on a dead line the set-point stays, however long") {
  ControllerBed bed({}, true);
  bed.make_ready();
  bed.load();
  bed.break_wire();
  CHECK_FALSE(bed.make_safe());
  bed.clock().wait_until(3600s);
  CHECK(bed.chamber.output().value() == Approx(5.0));
}

// The simulated module's serial line: requests of every length, in pieces, damaged, for other units, and its faults.

namespace {

using RawBytes = RawLine::Bytes;

const RawBytes kReadTime{1, 3, 0x11, 0x20, 0, 1}, kTime{1, 3, 2, 0x03, 0xE8};

struct SimulatedLine {
  explicit SimulatedLine(const SimulatedModuleFaults& faults = {})
      : server({{1, module_profile("beckhoff-ek9000"), {}}, {7, module_profile("generic"), {}}},
               SimulatedModule::Wire::kRtu, 0, chamber, clock, faults) {}
  void ask(const RawBytes& body) const { client.send(rtu_frame(body)); }
  // Whether this answer, with its check sum, comes.
  [[nodiscard]] bool answers(const RawBytes& body) const {
    const RawBytes frame = rtu_frame(body);
    return client.receive(frame.size()) == frame;
  }
  [[nodiscard]] bool answers(const RawBytes& request, const RawBytes& body) const {
    ask(request);
    return answers(body);
  }
  // After a silence what came is noise. A machine that holds the line up may not notice the first silence.
  [[nodiscard]] bool answers_after_a_silence() const {
    for (int i = 0; i < 40; ++i) {
      if (!client.receive(1, 300).empty()) return false;
      ask(kReadTime);
      if (client.receive(7, 1000) == rtu_frame(kTime)) return true;
    }
    return false;
  }
  ManualClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
  RawLine client{server.serial_port()};
};

}  // namespace

TEST_CASE("simulated RTU line: requests of each function code are read by their own length") {
  const SimulatedLine line;
  CHECK(line.server.port() == 0);
  REQUIRE(line.answers(kReadTime, kTime));
  REQUIRE(line.answers({1, 16, 0x08, 0x00, 0, 1, 2, 0x10, 0x00}, {1, 16, 0x08, 0x00, 0, 1}));
  REQUIRE(line.answers({1, 16, 0x11, 0x22, 0, 2, 4, 0, 2, 0, 1}, {1, 16, 0x11, 0x22, 0, 2}));
  REQUIRE(line.answers({1, 23, 0x11, 0x22, 0, 2, 0x08, 0x00, 0, 1, 2, 0x20, 0x00}, {1, 23, 4, 0, 2, 0, 1}));
  REQUIRE(line.answers({1, 6, 0x11, 0x24, 0, 0}, {1, 6, 0x11, 0x24, 0, 0}));
  REQUIRE(line.answers({1, 23, 0x08, 0x00, 0, 1, 0x11, 0x22, 0, 2, 4, 0, 1, 0, 0}, {1, 23, 2, 0x20, 0x00}));
  REQUIRE(line.answers({1, 4, 0, 0, 0, 1}, {1, 4, 2, 0x20, 0x00}));
  CHECK(line.chamber.output().value() == Approx(10.0 * 0x2000 / 0x7FFF));
}

TEST_CASE("simulated RTU line: each unit answers its own requests, and other unit numbers get no answer") {
  const SimulatedLine line;
  REQUIRE(line.answers({7, 6, 0, 0, 0x01, 0x23}, {7, 6, 0, 0, 0x01, 0x23}));
  REQUIRE(line.answers({7, 3, 0, 0, 0, 1}, {7, 3, 2, 0x01, 0x23}));
  REQUIRE(line.answers({7, 3, 0x11, 0x20, 0, 1}, {7, 0x83, 2}));
  for (const std::uint8_t unit : RawBytes{0, 2, 6, 8}) {
    line.ask({unit, 3, 0, 0, 0, 1});
    CHECK(line.client.is_silent());
  }
  REQUIRE(line.answers(kReadTime, kTime));
}

TEST_CASE("simulated RTU line: accepts a request byte by byte, several at once, and drops one that breaks off") {
  const SimulatedLine line;
  for (const std::uint8_t byte : rtu_frame(kReadTime)) line.client.send({byte});
  REQUIRE(line.answers(kTime));
  for (const std::uint8_t byte : rtu_frame(RawBytes{1, 16, 0x08, 0x00, 0, 1, 2, 0x10, 0x00})) line.client.send({byte});
  REQUIRE(line.answers({1, 16, 0x08, 0x00, 0, 1}));
  for (const std::uint8_t byte : rtu_frame(RawBytes{1, 23, 0x11, 0x20, 0, 1, 0x08, 0x00, 0, 1, 2, 0x20, 0x00})) {
    line.client.send({byte});
  }
  REQUIRE(line.answers({1, 23, 2, 0x03, 0xE8}));
  RawBytes three;
  for (int i = 0; i < 3; ++i) {
    const RawBytes one = rtu_frame(kReadTime);
    three.insert(three.end(), one.begin(), one.end());
  }
  line.client.send(three);
  for (int i = 0; i < 3; ++i) REQUIRE(line.answers(kTime));
  line.client.send({1, 3, 0x11, 0x20});
  CHECK(line.answers_after_a_silence());
}

TEST_CASE("simulated RTU line: does not answer a request with a damaged byte, nor one that follows it at once") {
  const SimulatedLine line;
  for (const std::size_t damaged : {0, 2, 5, 6, 7}) {
    INFO("byte " << damaged);
    RawBytes bytes = rtu_frame(kReadTime);
    bytes[damaged] = static_cast<std::uint8_t>(bytes[damaged] ^ 4U);
    const RawBytes next = rtu_frame(kReadTime);
    bytes.insert(bytes.end(), next.begin(), next.end());
    line.client.send(bytes);
    REQUIRE(line.answers_after_a_silence());
  }
}

TEST_CASE("simulated RTU line: each injected fault has its specified effect on the answer") {
  SimulatedModuleFaults faults;
  NextFault next(faults);
  SimulatedLine line(faults);
  const auto asks = [&](InjectedFault fault) {
    next = fault;
    next.meets([&] { line.ask(kReadTime); });
  };
  asks(InjectedFault::kNone);
  REQUIRE(line.answers(kTime));
  for (const InjectedFault silent : {InjectedFault::kSilent, InjectedFault::kUnplugged}) {
    asks(silent);
    CHECK(line.client.is_silent());
  }
  asks(InjectedFault::kRefused);
  REQUIRE(line.answers({1, 0x83, 4}));
  asks(InjectedFault::kCorrupt);
  RawBytes corrupt = rtu_frame(kTime);
  corrupt[1] ^= 0x10U;
  CHECK(line.client.receive(corrupt.size()) == corrupt);
  asks(InjectedFault::kLate);
  CHECK(line.client.is_silent());
  asks(InjectedFault::kNone);
  REQUIRE(line.answers(kTime));
  REQUIRE(line.answers(kTime));
  CHECK(line.client.is_silent());
  const RawBytes reference{1, 4, 0, 1, 0, 1};
  REQUIRE(line.answers(reference, {1, 4, 2, 0, 0}));
  line.chamber.reference_volts = Volts(10.0);
  next = InjectedFault::kStale;
  REQUIRE(line.answers(reference, {1, 4, 2, 0, 0}));
  next = InjectedFault::kNone;
  REQUIRE(line.answers(reference, {1, 4, 2, 0x7F, 0xFF}));
}

TEST_CASE("simulated RTU line: stays silent or hangs up after the set number of requests to its units") {
  for (const long after : {0L, 1L, 2L}) {
    INFO(after << " requests");
    const SimulatedLine silent({.silent_after_requests = after});
    const SimulatedLine dead({.dead_after_requests = after});
    for (const SimulatedLine* line : {&silent, &dead}) {
      line->ask({9, 3, 0, 0, 0, 1});  // of no unit here: it does not count
      CHECK(line->client.is_silent());
      for (long i = 0; i < after; ++i) {
        line->ask(kReadTime);
        CHECK(line->answers(kTime));
      }
      line->ask(kReadTime);
    }
    CHECK(silent.client.is_silent());
    REQUIRE(dead.client.is_closed());
  }
}
