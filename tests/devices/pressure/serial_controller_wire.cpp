// The serial pressure controller joins the table of actuator laws; tests of its further promises, against its simulated
// end on a pseudo-terminal.
#include "devices/pressure/serial_controller.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "devices/pressure/simulated_controller.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/actuator_contract.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

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
